"""The headline of an exploration."""

from __future__ import annotations

from collections import Counter

from flights.results import run_summary


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
    seconds, world = told["time_99_s"], told.get("world")
    in_time = "" if seconds is None else f"; 99 % of these {told['known_m3']:.0f} m3 after {seconds:.0f} s"
    return {
        "known on the map": f"{told['known_m3']:.0f} m3, free or occupied{in_time}",
        **({"known of the world": _of_world(world)} if world else {}),
        "home": f"{'yes' if told['is_home'] else 'no'}, after {told['home_s']:.0f} s",
        "views, swaps": f"{told['views']}, {told['swaps']}",
        **_of_the_map(
            told.get("height_uncertain_m"), told.get("home_height_off_m"), told.get("doubled_share")
        ),
        **{f"unknown border {n}": f"{area:.1f} m2: {why}" for n, (why, area) in enumerate(areas.items(), 1)},
    }


def _of_the_map(sigma_m: float | None, off_m: float | None, doubled: float | None) -> dict[str, str]:
    """Return how well the height was known, and what of the map's floors lies doubled."""
    words = {}
    if sigma_m is not None:
        words["height"] = f"known with a standard deviation of {sigma_m:.2f} m, at its worst"
    if off_m is not None:
        words["height at home"] = f"off by {off_m:.2f} m after the landing"
    if doubled is not None:
        words["floors doubled"] = f"{100.0 * doubled:.0f} % of the map's floors and ceilings"
    return words


def _of_world(world: dict) -> str:
    """Return what the simulator knows better than the UAV. world: see `WorldShare`."""
    return (
        f"{100.0 * world['known_share']:.0f} % of the {world['room_m3']:.0f} m3 of all rooms that openings "
        "join with the start's, also those that are too narrow for this UAV"
    )
