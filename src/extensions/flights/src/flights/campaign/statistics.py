"""Rates and means of a campaign's table, with their 95 % confidence intervals."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
import pandas as pd
import scipy  # loads stats at its first use; that takes half a second

from flights.campaign.campaign import Campaign

CONFIDENCE = 0.95
RESAMPLES = 2000
RATES = {"flight": ("collision", "reached", "stuck"), "mapping": ("collision", "mapped", "stuck")}
OF_ARRIVED = ("flight_time_s", "time_over_straight", "path_length_m")
"""Means of flights that arrived, because a collision ends a flight early."""
MEANS = {
    "flight": (*OF_ARRIVED, "min_clearance_m", "emergencies"),
    "mapping": (
        "ate_rmse_m",
        "ate_online_rmse_m",
        "odometry_ate_rmse_m",
        "map_error_mean_m",
        "map_error_p95_m",
        "wall_seen_share",
        "min_clearance_m",
    ),
}


def wilson(events: int, trials: int) -> tuple[float, float]:
    """Return the score interval of a rate (Wilson 1927); 0 to 1 when nothing was tried."""
    if trials == 0:
        return 0.0, 1.0
    interval = scipy.stats.binomtest(events, trials).proportion_ci(CONFIDENCE, method="wilson")
    return float(interval.low), float(interval.high)


def bootstrap(values: np.ndarray, rng: np.random.Generator) -> tuple[float, float]:
    """Return the percentile bootstrap interval (Efron 1979) of the mean of values (n,).

    Fewer than two values have no interval: NaN.
    """
    values = np.asarray(values, dtype=float)
    if len(values) < 2:
        return math.nan, math.nan
    means = rng.choice(values, (RESAMPLES, len(values))).mean(axis=1)
    low, high = np.quantile(means, ((1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2))
    return float(low), float(high)


def summary(campaign: Campaign, trials: pd.DataFrame) -> pd.DataFrame:
    """Return one row for each combination that varies: rates and means, each with `_low` and `_high`.

    Trials that failed are counted in `errors` and nowhere else. commits: of the code that computed the row.
    """
    names = list(campaign.varied)
    groups = trials.groupby(names, sort=False, dropna=False) if names else [((), trials)]
    rows = []
    for number, (values, group) in enumerate(groups):
        values = values if isinstance(values, tuple) else (values,)
        commits = " ".join(dict.fromkeys(group["commit"]))
        rows.append({**dict(zip(names, values)), **metrics(campaign, group, number), "commits": commits})
    return pd.DataFrame(rows)


def metrics(campaign: Campaign, group: pd.DataFrame, number: int = 0) -> dict[str, float]:
    """Return rates and means of some trials. number: gives the bootstrap a random stream of its own."""
    flown = group[group["error"].isna()]
    found: dict[str, float] = {"trials": len(group), "errors": len(group) - len(flown)}
    for name in RATES[campaign.kind]:
        events = int(flown[name].sum())
        _put(
            found, f"{name}_rate", events / len(flown) if len(flown) else math.nan, wilson(events, len(flown))
        )
    rng = np.random.default_rng(np.random.SeedSequence((campaign.seed, number)))
    for name in MEANS[campaign.kind]:
        counted = flown[flown["reached"].astype(bool)] if name in OF_ARRIVED else flown
        values = counted[name].dropna().to_numpy(dtype=float)
        _put(found, f"{name}_mean", values.mean() if len(values) else math.nan, bootstrap(values, rng))
    return found


def _put(found: dict, name: str, value: float, interval: Sequence[float]) -> None:
    found[name], found[f"{name}_low"], found[f"{name}_high"] = float(value), *interval
