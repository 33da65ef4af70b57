"""The headline of an exploration."""

from __future__ import annotations

from collections import Counter

from master_thesis.results import run_summary


def headline(content: dict) -> str:
    """Return the figures of an exploration in a few lines for a terminal."""
    told = content["exploration"]
    rows = {"end": told["end"] or "-", "because": told["reason"], **rows_of(told)}
    lines = [run_summary.headline(content)]
    return "\n".join([*lines, *(f"  {name:<22} {value}" for name, value in rows.items())])


def rows_of(told: dict) -> dict[str, str]:
    """Return what was explored, by name. told: the exploration of result.json."""
    if not told["end"]:
        return {}
    areas: Counter = Counter()
    for place in told["unknown"]:
        areas[place["why"]] += place["border_m2"]
    seconds = told["time_99_s"]
    return {
        "known": f"{told['known_m3']:.0f} m3"
        + ("" if seconds is None else f", 99 % of it after {seconds:.0f} s"),
        "home": f"{'yes' if told['is_home'] else 'no'}, after {told['home_s']:.0f} s",
        "views, swaps": f"{told['views']}, {told['swaps']}",
        **{f"unknown border {n}": f"{area:.1f} m2: {why}" for n, (why, area) in enumerate(areas.items(), 1)},
    }
