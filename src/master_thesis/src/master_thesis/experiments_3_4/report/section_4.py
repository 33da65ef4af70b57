"""Experiment 4 on the page: the cargo hold, figures 8.13 to 8.17."""

from __future__ import annotations

from flights.mapping.mapping_flight import SCENARIOS
from flights.trials.store import Store
from flights.trials.trial import Row
from master_thesis.experiments_3_4.report.claim_metrics import hold_metrics
from master_thesis.experiments_3_4.report.maps import (
    Maps,
    map_picture,
    map_pictures,
    maps_of,
    maps_table,
    range_chart,
)
from master_thesis.experiments_3_4.report.pieces import OPEN, tim_of_the_text
from master_thesis.report import thesis
from master_thesis.report.claims import judged
from master_thesis.report.content import Block, Section, Table, counted, number, seeds_of
from master_thesis.report.size import Size


def section(size: Size, store: Store) -> Section:
    """Return the section of the pieces that are there."""
    maps, shown = maps_of("hold", size, store)
    speed_m_s = SCENARIOS["hold"].speed_m_s
    text = _tim_of_the_text(size, store)
    blocks: list[Block] = []
    if maps.lidars:
        blocks = [maps_table(maps, "The maps of the hold"), range_chart(maps)]
        blocks += [_by_seed(maps, lidar) for lidar in ("urg", "ust") if lidar in maps.lidars]
        blocks += map_pictures(maps, shown)
    blocks += [
        map_picture(
            f"SICK TiM with the text's {thesis.TIM_RANGE_IN_TEXT_M:g} m",
            thesis.MAPS["hold"]["tim"],
            done,
            OPEN,
        )
        for done in text
        if OPEN in done.result["pictures"]
    ]
    return Section(
        key="experiment_4",
        title="Experiment 4: SLAM in a cargo hold",
        reference="8.2, figures 8.13 to 8.17; discussed in 9.1.2",
        method=(
            "The UAV flies one round trip along the walls of a hold of 30 x 20 m, whose beams repeat "
            f"every 3 m, at {speed_m_s:g} m/s and 3 m from the plating, by the ground truth; its "
            "odometry drifts. gridslam maps the recorded scans, without loop closure as gmapping does, "
            "and with it."
        ),
        blocks=blocks,
        findings=judged("experiment_4", hold_metrics(maps, [done.result[OPEN] for done in text])),
        parameters=f"{seeds_of(size.map_seeds)}; one round trip at {speed_m_s:g} m/s",
    )


def _tim_of_the_text(size: Size, store: Store) -> list[Row]:
    """Return the flights of the TiM with the range in the thesis's text."""
    if "hold" not in size.worlds or "tim" not in size.lidars:
        return []
    found = (store.get(tim_of_the_text(size, seed)) for seed in size.map_seeds)
    return [done for done in found if done is not None]


def _by_seed(maps: Maps, lidar: str) -> Table:
    rows, worse = [], 0
    for without, closed in zip(maps.open[lidar], maps.closed[lidar]):
        worse += closed["ate_rmse_m"] > without["ate_rmse_m"]
        rows.append(
            (
                str(without["seed"]),
                *(number(metrics["ate_rmse_m"], 3) for metrics in (without, closed)),
                *(number(metrics["map_error_p95_m"], 3) for metrics in (without, closed)),
                *(number(metrics["end_error_m"], 3) for metrics in (without, closed)),
                str(closed["closures"]),
            )
        )
    header = (
        "seed",
        "trajectory error, m",
        "closed",
        "95 % of the map, m",
        "closed",
        "error at the end, m",
        "closed",
        "loops",
    )
    return Table(
        f"Flight by flight: {thesis.LIDARS[lidar].name}, without loop closure and with it",
        header,
        rows,
        note=f"With loop closure the path got worse in {worse} of {counted(len(rows), 'flight')}.",
    )
