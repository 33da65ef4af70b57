"""Compares Experiment 1's flights with the thesis: statements that agree, and that do not."""

from __future__ import annotations

from typing import Mapping, Sequence

import numpy as np

from master_thesis.report import thesis
from master_thesis.report.content import Finding, counted, listed, resting_on

STEADY = 1.25
"""Times are steady if the greatest is at most this many times the least; the thesis's: 1.19."""
HUGE = 3.0
"""The least reduction that the thesis calls huge: 17.0 to 5.1 ms in its forest."""
ORDER = "the scenarios in the order of their times"

Flights = Mapping[tuple, Sequence[dict]]
"""Numbers of the flights by (scenario, algorithm)."""


def findings(names: Sequence[str], flights: Flights) -> list[Finding]:
    """Return the thesis's statements beside our numbers."""
    if not names:
        return []
    found = [_reduction(names, flights)]
    if len(names) > 1:
        found.append(_stable(names, flights))
    if "empty" in names:
        found.append(_one_test(flights))
    if "empty" in names and len(names) > 1:
        found += [_fastest_in_the_empty_world(names, flights), _clutter(names, flights)]
    if set(names) == set(thesis.SCENARIO_FIGURES):
        found.append(_order(names, flights))
    found += [_in_time(names, flights), _untouched(names, flights)]
    fewest = min(len(flights[name, algorithm]) for name in names for algorithm in ("improved", "original"))
    return resting_on(found, fewest, "flight of each")


def _reduction(names: Sequence[str], flights: Flights) -> Finding:
    ratios = {name: ratio(flights, name) for name in names}
    least = min(ratios.values())
    slow = listed([name for name, value in ratios.items() if value < HUGE])
    return Finding(
        "“We see a huge reduction in computation time across the board!”",
        "9.1.1",
        f"The original takes {' to '.join(_ends(ratios))} times as long as the improved.",
        least >= HUGE,
        f"In {slow} it is less than the {HUGE:g} times of the thesis's forest.",
    )


def _stable(names: Sequence[str], flights: Flights) -> Finding:
    means = {name: _mean(flights, name, "original") for name in names}
    widest = max(means.values()) / min(means.values())
    theirs = thesis.TABLE_8_1_MS["original"]
    their_widest = max(theirs[n] for n in names) / min(theirs[n] for n in names)
    return Finding(
        "“The computation times for the original algorithm is quite stable”",
        "9.1.1",
        f"The slowest scenario takes {widest:.2f} times as long as the fastest (thesis: {their_widest:.2f}).",
        widest <= STEADY,
        f"A direction is given up at the first beam that forbids it, soonest in the {_least(means)}.",
    )


def _fastest_in_the_empty_world(names: Sequence[str], flights: Flights) -> Finding:
    means = {name: _mean(flights, name, "original") for name in names}
    return Finding(
        "The original saves a little time in the empty world.",
        "9.1.1",
        f"Fastest in {_least(means)}: {min(means.values()):.1f} ms; empty: {means['empty']:.1f} ms.",
        _least(means) == "empty",
        "Ours gives up a direction at the first beam that forbids it, so that obstacles save it "
        "time; the thesis's adjusts speeds there instead, which costs time.",
    )


def _one_test(flights: Flights) -> Finding:
    improved, original = (
        np.mean([f["directions"] for f in flights["empty", algorithm]])
        for algorithm in ("improved", "original")
    )
    return Finding(
        "In the open, testing v_ref first “reduces the … 1440 tests to 1!”",
        "9.1.1",
        f"Improved: {improved:.2f} directions a scan in the empty world; original: {original:.0f} (every "
        "seen beam at each of four speeds).",
        improved < 1.5 and original > 1000,
        "v_ref is not always clear there: the UAV leans, and the lidar sees the ground.",
    )


def _clutter(names: Sequence[str], flights: Flights) -> Finding:
    means = {name: _mean(flights, name, "improved") for name in names}
    return Finding(
        "“When the environment gets more cluttered, the time it takes for the improved algorithm … "
        "increases”.",
        "9.1.1",
        "Improved: " + ", ".join(f"{name} {value:.3f} ms" for name, value in means.items()) + ".",
        _least(means) == "empty",
        f"The {_least(means)} took less than the empty world.",
    )


def _order(names: Sequence[str], flights: Flights) -> Finding:
    ours = sorted(names, key=lambda name: _mean(flights, name, "improved"))
    theirs = sorted(names, key=lambda name: thesis.TABLE_8_1_MS["improved"][name])
    return Finding(
        f"Improved, {ORDER}: {' < '.join(theirs)}.",
        "table 8.1",
        f"Ours: {' < '.join(ours)}.",
        ours == theirs,
        "The worlds are built after the thesis's pictures, which give no measures: how narrow they "
        "are, and so how often v_ref is not clear, is our choice.",
    )


def _in_time(names: Sequence[str], flights: Flights) -> Finding:
    worst = max(f["computation_p99_ms"] for n in names for f in flights[n, "original"])
    return Finding(
        "“The original is still fast enough for a lidar at 40Hz”, which leaves 25 ms.",
        "8.1, 9.1.1",
        f"99 of 100 scans took the original less than {worst:.1f} ms in every flight.",
        worst < thesis.SCAN_PERIOD_MS,
        "On this machine, at the load of this run, it was not.",
    )


def _untouched(names: Sequence[str], flights: Flights) -> Finding:
    flown = [f for n in names for f in flights[n, "improved"]]
    touched, late = sum(f["collision"] for f in flown), sum(not f["reached_goal"] for f in flown)
    return Finding(
        "The improved algorithm “will no longer cause collisions”.",
        "9.1.1",
        f"{counted(touched, 'collision')} in {counted(len(flown), 'flight')}; {len(flown) - late} "
        "reached the goal.",
        not touched and not late,
        "See the table above for which.",
    )


def ratio(flights: Flights, name: str) -> float:
    """Return the ratio of the original's time to the improved's."""
    return _mean(flights, name, "original") / _mean(flights, name, "improved")


def _ends(values: Mapping[str, float]) -> list[str]:
    """Return the least and the greatest value, or one if both are written alike."""
    return list(dict.fromkeys(f"{end:.0f}" for end in (min(values.values()), max(values.values()))))


def times_ms(flights: Flights, name: str, algorithm: str) -> list[float]:
    """Return the flights' mean computation times."""
    return [flight["computation_ms"] for flight in flights[name, algorithm]]


def _mean(flights: Flights, name: str, algorithm: str) -> float:
    return float(np.mean(times_ms(flights, name, algorithm)))


def _least(means: Mapping[str, float]) -> str:
    return min(means, key=means.__getitem__)
