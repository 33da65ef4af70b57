"""The headline of an inspection."""

from __future__ import annotations

from flights.exploring.summary import rows_of
from flights.results import run_summary


def headline(content: dict) -> str:
    """Return the figures of an inspection in a few lines for a terminal."""
    told = content["inspection"]
    rows = _explored(content["exploration"]) if "exploration" in content else {}
    rows |= {"end": told["end"] or "-", "because": told["reason"]}
    if "taken" in told:
        rows["photographs"] = (
            f"{told['taken']} of {told['asked']} taken with {told['shots']} shots, {told['open']} open, "
            f"{len(told['left_out'])} left out"
        )
        rows["second look"] = f"{told.get('closer', 0)} closer photographs"
        rows["batteries"] = f"{told['swaps'] + 1}, {told['flight_s'] / 60.0:.1f} min of flight"
    told_of = told.get("taken", 0) + told.get("closer", 0)
    if told.get("stored", told_of) > told_of:
        rows["stored"] = f"{told['stored']} photographs, also those of the interrupted flight"
    for each in told.get("left_out", [])[:5]:
        rows[f"photograph {each['photograph']}"] = each["why"]
    coverage = told.get("coverage")
    if coverage:
        rows["shown of the world"] = (
            f"{coverage['shown_m2']:.0f} of {coverage['reachable_m2']:.0f} m2 "
            f"({100 * coverage['share_by_truth']:.1f} %), by the true poses"
        )
        surface = coverage["told"]
        rows[f"shown of the {coverage['of']}"] = (
            f"{surface['shown_m2']:.0f} of {surface['reachable_m2']:.0f} m2 "
            f"({100 * coverage['share_by_slam']:.1f} %), by SLAM's poses; planned "
            f"{100 * coverage['share_planned']:.1f} %"
        )
        if coverage["drawing"] is not None:
            rows["not on the map"] = f"{coverage['drawing']['not_mapped_m2']:.0f} m2 of the world"
        rows["area per minute"] = f"{told['m2_per_min']:.0f} m2"
        off_m, off_deg = coverage["pose_error_m"], coverage["pose_error_deg"]
        rows["camera's pose off"] = (
            f"median {off_m['median']:.2f} m and {off_deg['median']:.1f} deg, "
            f"at most {off_m['max']:.2f} m and {off_deg['max']:.1f} deg"
        )
    lines = [run_summary.headline(content)]
    return "\n".join([*lines, *(f"  {name:<22} {value}" for name, value in rows.items())])


def _explored(told: dict) -> dict[str, str]:
    return {"explored": f"{told['end'] or '-'}: {told['reason']}", **rows_of(told)}
