"""Experiment 3 on the page: the room, figures 8.8 to 8.12."""

from __future__ import annotations

from master_thesis.experiments_3_4.mapping_flight import SCENARIOS
from master_thesis.report import thesis
from master_thesis.report.content import Block, Finding, Section, listed, resting_on, seeds_of
from master_thesis.report.sections.maps import (
    Maps,
    map_pictures,
    maps_of,
    maps_table,
    range_chart,
    short_name,
)
from master_thesis.report.size import Size
from master_thesis.trials.store import Store

DRIFTED_M = 0.25
"""If a mapped wall is farther than this from every true wall, it is visibly wrong."""


def section(size: Size, store: Store) -> Section:
    """Return the section of the pieces that are there."""
    maps, shown = maps_of("room", size, store)
    scenario = SCENARIOS["room"]
    duration_s = size.map_duration_s or scenario.duration_s
    blocks: list[Block] = []
    if maps.lidars:
        blocks = [maps_table(maps, "The maps of the room"), range_chart(maps), *map_pictures(maps, shown)]
    return Section(
        key="experiment_3",
        title="Experiment 3: SLAM in a normal environment",
        reference="8.2, figures 8.8 to 8.12; discussed in 9.1.2",
        method=(
            f"The UAV flies {duration_s:g} s through a room of 16 x 12 m with walls, boxes, columns and "
            f"a bookshelf, at {scenario.speed_m_s:g} m/s, by the ground truth; its odometry drifts. "
            "gridslam, a Rao-Blackwellised particle filter with gmapping's parameters, maps the "
            "recorded scans, without loop closure as gmapping does, and with it."
        ),
        blocks=blocks,
        findings=findings(maps),
        parameters=f"{seeds_of(size.map_seeds)}; {duration_s:g} s at {scenario.speed_m_s:g} m/s",
    )


def findings(maps: Maps) -> list[Finding]:
    """Return the thesis's statements beside our numbers."""
    found = []
    if maps.lidars:
        found.append(_all_good(maps))
    if "urg" in maps.lidars and len(maps.lidars) > 1:
        found.append(_less_complete(maps))
    if "tim" in maps.lidars:
        found.append(_corrected(maps))
    return resting_on(found, maps.fewest, "flight of each")


def _all_good(maps: Maps) -> Finding:
    bad = [lidar for lidar in maps.lidars if not maps.is_true(lidar)]
    worst = max(maps.lidars, key=lambda lidar: maps.middle(lidar)["map_error_p95_m"])
    return Finding(
        "“In Experiment 3 all lidars do a pretty good job.”",
        "9.1.2",
        f"{len(maps.lidars) - len(bad)} of {len(maps.lidars)} maps are true to the world; the worst is "
        f"the {short_name(worst)}'s, 95 % of it within {maps.middle(worst)['map_error_p95_m']:.3f} m of "
        "a wall.",
        not bad,
        "" if not bad else f"Not so of {listed([short_name(each) for each in bad])}: {maps.verdict(bad[0])}.",
    )


def _less_complete(maps: Maps) -> Finding:
    seen = {lidar: maps.middle(lidar)["wall_seen_share"] for lidar in maps.lidars}
    others = max(value for lidar, value in seen.items() if lidar != "urg")
    least = min(seen, key=seen.__getitem__)
    return Finding(
        "“The URG-04LX-UG01 has a slightly less complete map”, due to its short range.",
        "9.1.2, figure 8.10a",
        f"The URG's map shows {100 * seen['urg']:.0f} % of the true walls, the most complete one "
        f"{100 * others:.0f} %.",
        least == "urg",
        "Our flight comes near to every wall in its time, so that range does not decide; the "
        f"least, of the {short_name(least)}, is {100 * seen[least]:.0f} %.",
    )


def _corrected(maps: Maps) -> Finding:
    middle = maps.middle("tim")
    half, end = middle["half_way_error_max_m"], middle["map_error_max_m"]
    why = "What was off at half time is so at the end."
    if half <= DRIFTED_M:
        why = "No wall was ever that far off: the filter corrects the drift scan by scan before it shows."
    return Finding(
        "TiM: at half time a wall is drawn where odometry has drifted to; it is corrected when seen again.",
        f"figure {thesis.MAPS['room']['tim'].figure}",
        f"Farthest that an occupied cell is from a true wall: {half:.2f} m at half time, {end:.2f} m at "
        f"the end; trajectory error as believed in flight {middle['ate_online_rmse_m']:.3f} m, at the "
        f"end {middle['ate_rmse_m']:.3f} m.",
        half > DRIFTED_M and end < half / 2,
        why,
    )
