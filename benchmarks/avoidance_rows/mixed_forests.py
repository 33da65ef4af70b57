"""The campaign `avoidance`, flights through random forests: does CEPA collide, arrive, or get stuck?

The improved algorithm must never collide at 2 m/s. Keys: cepa.campaign.{original, improved,
improved_velocity_aware, improved_levelling}.{all, 1_m_s, ...}, where each speed counts the same forests, and
cepa.campaign.improved_at_2_m_s, in four times as many. Each has collisions per km with their exact 95 %
interval, share stuck and time to goal.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
import scipy  # loads stats at its first use; that takes half a second

from benchmarks.shared.results import Results, table
from flights.campaign.campaign import Campaign

SAFE_SPEED_M_S = 2.0
SAFE = f"improved_at_{SAFE_SPEED_M_S:g}_m_s"
EXTENSIONS = {
    "velocity_aware": "cepa.velocity_aware_emergency",
    "levelling": "cepa.levelling",
}
"""The improved algorithm's extensions that are off by default."""


def compared(campaign: Campaign, trials: pd.DataFrame, results: Results) -> str:
    """Add the flights' numbers to the results; return them as text."""
    found = {name: metrics(flights) for name, flights in sets(campaign, trials).items()}
    for name, values in found.items():
        results.add(f"cepa.campaign.{name}", values)
    return f"{as_table(found)}\n{failures(trials)}"


def names(trials: pd.DataFrame) -> pd.Series:
    """Return for each trial the algorithm, with its extension if it had one."""
    found = trials["algorithm"].astype(str)
    for name, column in EXTENSIONS.items():
        found = found.where(~trials[column].astype(bool), found + f"_{name}")
    return found


def sets(campaign: Campaign, trials: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the flights by key: improved at 2 m/s in all forests, others where all speeds flew."""
    of = names(trials)
    found = {SAFE: trials[(of == "improved") & (trials["speed_m_s"] == SAFE_SPEED_M_S)]}
    shared = trials["replicate"] < campaign.seeds
    for name in dict.fromkeys(of):
        mine = trials[(of == name) & shared]
        found[f"{name}.all"] = mine
        found.update({f"{name}.{speed:g}_m_s": flights for speed, flights in mine.groupby("speed_m_s")})
    return found


def metrics(flights: pd.DataFrame) -> dict:
    """Return the metrics of some flights."""
    kilometres = 1e-3 * flights["path_length_m"].sum()
    collisions = int(flights["collision"].sum())
    arrived = flights[flights["reached"].astype(bool)]
    times, straight = arrived["flight_time_s"], arrived["time_over_straight"]
    return {
        "flights": len(flights),
        "distance_km": kilometres,
        "collisions": collisions,
        "collisions_per_km": collisions / kilometres,
        "collisions_per_km_95": rate_interval(collisions, kilometres),
        "stuck": flights["stuck"].mean(),
        "reached": flights["reached"].mean(),
        "time_to_goal_s": {"mean": times.mean(), "std": np.std(times)} if len(arrived) else None,
        "time_over_straight": straight.median() if len(arrived) else None,
        "clearance_m": {
            "least": flights["min_clearance_m"].min(),
            "median": flights["min_clearance_m"].median(),
        },
        "flights_with_emergency": (flights["emergencies"] > 0).mean(),
    }


def rate_interval(events: int, exposure: float, confidence: float = 0.95) -> tuple[float, float]:
    """Return the exact (Garwood 1936) confidence interval of a Poisson rate: events per unit of exposure."""
    tail = (1.0 - confidence) / 2.0
    quantile = scipy.stats.chi2.ppf
    low = quantile(tail, 2 * events) / 2.0 if events else 0.0
    return float(low / exposure), float(quantile(1.0 - tail, 2 * events + 2) / 2.0 / exposure)


def as_table(found: dict[str, dict]) -> str:
    """Return the metrics as a table; time: over that of a straight flight at full speed, median."""
    header = (
        "flights",
        "number",
        "km",
        "collisions",
        "per km",
        "95 %",
        "stuck",
        "time/straight",
        "clearance [m]",
    )
    return table(header, [(name.replace(".", ", "), *_row(values)) for name, values in found.items()])


def _row(values: dict) -> tuple[str, ...]:
    low, high = values["collisions_per_km_95"]
    longer, clearance = values["time_over_straight"], values["clearance_m"]
    return (
        f"{values['flights']}",
        f"{values['distance_km']:.2f}",
        f"{values['collisions']}",
        f"{values['collisions_per_km']:.2f}",
        f"{low:.2f} to {high:.2f}",
        f"{values['stuck']:.1%}",
        f"{longer:.2f}" if longer else "-",
        f"{max(clearance['least'], 0.0):.2f}, median {clearance['median']:.2f}",
    )


def failures(trials: pd.DataFrame) -> str:
    """Return a line for each flight that did not arrive."""
    lost = trials.assign(flown_by=names(trials))[~trials["reached"].astype(bool)]
    return "\n".join(
        f"forest {f['replicate']:3d}, {f['flown_by']}, {f['speed_m_s']:g} m/s: "
        f"{'collision' if f['collision'] else 'stuck'} after {f['flight_time_s']:.1f} s"
        for f in lost.to_dict("records")
    )
