"""The way home as it was reckoned when the UAV turned back, beside what it took: time and energy.

The seed draws the place, and after how long the UAV turns back. The battery is full, so that only the time
ends the exploration.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np

from benchmarks.explore_rows.batteries import ENERGY, PLACES
from exploration.energy import EnergyWatch
from exploration.next_view import Explored
from flights.exploring.flight import ExploringFlight
from flights.exploring.places import place_of
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.parameters import ClosedLoopParameters
from simulation_tools.simulation import StepOutput
from simulation_tools.vehicle.energy.battery import BatteryStart

ROW = "way_home"
SEEDS = tuple(range(2001, 2021))
KINDS = (*PLACES, "shaft", "under")
"""Of places. The last two lead up and down."""
TIME_S, LONGEST_S = (15.0, 40.0), 200.0
"""The UAV turns back after a time between these; after the third it lands where it is."""
SHORTEST_M = 2.0
"""The ratio of a shorter way says little: it takes as long as the UAV takes to settle over its home."""
STEEP_SHARE = 0.5
"""A way that leads so much of its length up, or down, counts as one that does."""
S_PER_H = 3600.0


class MeteredLoop(ClosedLoop):
    """A closed loop that notes what the battery has given."""

    def __init__(self, parameters: ClosedLoopParameters) -> None:
        super().__init__(parameters)
        self._given: list[tuple[float, float, float]] = [(self.time_s, 0.0, 1.0)]
        """Time in s, Wh, and the charge."""

    def step(self) -> StepOutput:
        """See `ClosedLoop.step`."""
        output, power = super().step(), self.simulation.power
        assert power is not None  # each UAV of a row has a battery
        before_s, given_wh, _ = self._given[-1]
        given_wh += power.power_w * (self.time_s - before_s) / S_PER_H
        self._given.append((self.time_s, given_wh, power.battery.remaining))
        return output

    def given_at(self, time_s: float) -> tuple[float, float]:
        """Return the Wh that the battery had given at a time, and its charge."""
        times_s, given_wh, charges = np.array(self._given).T
        return float(np.interp(time_s, times_s, given_wh)), float(np.interp(time_s, times_s, charges))


def fly(seed: int) -> dict:
    """Explore a place for a while and come home; return times in s, lengths in m and energies in Wh."""
    rng = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    place = place_of(kind, seed)
    asked = place.asked(float(rng.uniform(*TIME_S)))
    with tempfile.TemporaryDirectory() as folder:
        given = place.loop_parameters(place.written_to(Path(folder)), seed, LONGEST_S)
        given = replace(given, simulation=replace(given.simulation, battery=BatteryStart()))
        with MeteredLoop(given) as loop:
            flight = ExploringFlight(
                loop, place.planner, place.explorer, place.volume, asked, EnergyWatch(ENERGY)
            )
            explored = flight.run()
            outcome = loop.outcome
            return {
                "place": kind,
                "ended": explored.end.value if explored.end else "",
                "landed": outcome.landed,
                "contact": outcome.collision,
                **compared(explored, loop, outcome.times_s),
            }


def compared(explored: Explored, loop: MeteredLoop, times_s: dict[Phase, float]) -> dict:
    """Return the way home as it was reckoned when the UAV turned back, beside what it took.

    A time that never came is NaN.
    """
    way, nan, home_s = explored.way_home, math.nan, times_s.get(Phase.HOVERING, math.nan)
    (turned_wh, turned), (home_wh, _) = loop.given_at(explored.ended_s), loop.given_at(home_s)
    full_wh = turned_wh / (1.0 - turned)
    return {
        "reckoned_m": way.length_m if way else nan,
        "up_m": way.up_m if way else nan,
        "down_m": way.down_m if way else nan,
        "reckoned_s": way.time_s if way else nan,
        "flown_s": home_s - explored.ended_s,
        "landing_s": times_s.get(Phase.DONE, nan) - home_s,
        "reckoned_wh": full_wh * explored.way_home_charge,
        "flown_wh": home_wh - turned_wh,
        "full_wh": full_wh,
    }


def summary(flights: Sequence[dict]) -> dict:
    """Return how many ways took longer than the energy watch allows for, and the ratios flown to reckoned.

    It allows for `margin` times the reckoned time and for `settling_time`; the landing has a time of its own.
    A UAV that did not come home counts as one that took longer. up, down: of ways that lead there.
    """
    long = [f for f in flights if f["reckoned_m"] >= SHORTEST_M]
    allowed = [ENERGY.margin * f["reckoned_s"] + ENERGY.settling_time for f in flights]
    over_s = [
        f["flown_s"] - most if f["flown_s"] < math.inf else math.inf for f, most in zip(flights, allowed)
    ]
    return {
        "flights": len(flights),
        "longer_than_allowed": sum(not seconds <= 0.0 for seconds in over_s),
        "least_to_spare_s": -max(over_s, default=math.nan),
        "longer_than_factor": sum(not f["flown_s"] <= ENERGY.margin * f["reckoned_s"] for f in flights),
        "ways": len(long),
        **_ratios("", long, "s"),
        **_ratios("up_", [f for f in long if f["up_m"] >= STEEP_SHARE * f["reckoned_m"]], "s"),
        **_ratios("down_", [f for f in long if f["down_m"] >= STEEP_SHARE * f["reckoned_m"]], "s"),
        **_ratios("energy_", long, "wh"),
        "landing_s": max((f["landing_s"] for f in flights), default=math.nan),
        "longest_m": max((f["reckoned_m"] for f in flights), default=math.nan),
        "contacts": sum(f["contact"] for f in flights),
    }


def _ratios(name: str, flights: Sequence[dict], unit: str) -> dict[str, float]:
    """Return of the ratios flown to reckoned the median, the 99th percentile and the greatest."""
    ratios = [f[f"flown_{unit}"] / f[f"reckoned_{unit}"] for f in flights]
    known = [ratio for ratio in ratios if math.isfinite(ratio)]
    return {
        f"{name}ratio_median": float(np.median(known)) if known else math.nan,
        f"{name}ratio_99": float(np.quantile(known, 0.99)) if known else math.nan,
        f"{name}ratio_greatest": max(known, default=math.nan),
    }
