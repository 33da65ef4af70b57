"""Experiment 3 on the page: the room, figures 8.8 to 8.12."""

from __future__ import annotations

from flights.mapping.mapping_flight import SCENARIOS
from flights.trials.store import Store
from master_thesis.experiments_3_4.report.claim_metrics import room_metrics
from master_thesis.experiments_3_4.report.maps import map_pictures, maps_of, maps_table, range_chart
from master_thesis.report.claims import judged
from master_thesis.report.content import Block, Section, seeds_of
from master_thesis.report.size import Size


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
        findings=judged("experiment_3", room_metrics(maps)),
        parameters=f"{seeds_of(size.map_seeds)}; {duration_s:g} s at {scenario.speed_m_s:g} m/s",
    )
