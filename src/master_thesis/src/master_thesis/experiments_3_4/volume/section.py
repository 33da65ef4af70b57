"""The hold in three dimensions on the page."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from flights.trials.store import Store
from master_thesis.experiments_3_4.volume.flight import RANGE_M, RESOLUTION_M
from master_thesis.experiments_3_4.volume.pieces import EXPERIMENT, PICTURE, piece
from master_thesis.report import thesis
from master_thesis.report.content import Block, Picture, Section, Table, number, seeds_of
from master_thesis.report.size import Size

COLUMNS = {
    "volume_error_mean_m": ("distance of occupied voxels from the true surface, m", 1.0, 3),
    "volume_error_p95_m": ("95 %, m", 1.0, 3),
    "occupied_within_a_voxel_share": ("within a voxel, %", 100.0, 1),
    "visible_surface_m2": ("surface that could be seen, m²", 1.0, 0),
    "visible_surface_mapped_share": ("of it mapped, %", 100.0, 1),
    "least_mapped_share": ("of the least mapped beam or side, %", 100.0, 1),
    "free_right_share": ("free voxels that are right, %", 100.0, 1),
    "clouds": ("clouds", 1.0, 0),
    "ate_rmse_m": ("error of SLAM's path, m", 1.0, 3),
}
"""Heading, factor and decimals of each figure."""


def section(size: Size, store: Store) -> Section:
    """Return the section of the pieces that are there."""
    flown = {}
    for lidar in size.volumes:
        rows = (store.get(piece(size, lidar, seed)) for seed in size.map_seeds)
        done = [row.result for row in rows if row is not None]
        if done:
            flown[lidar] = done
    blocks: list[Block] = [_table(flown)] if flown else []
    for lidar, results in flown.items():
        blocks += [_picture(lidar, each) for each in results if PICTURE in each["pictures"]]
    return Section(
        key=EXPERIMENT,
        title="Experiment 4 in three dimensions",
        reference="not in the thesis, which maps a plane and asks for a SLAM that can grow (1.2)",
        method=(
            "The flights of Experiment 4 with the lidars that have clouds, and with planar ones that nod at "
            "stops along the same way. The clouds enter a map of voxels "
            "at poses of odometry that SLAM's path corrects. Rays from the true path through the world "
            "tell which surface the lidar could see."
        ),
        blocks=blocks,
        findings=(),
        parameters=(
            f"{seeds_of(size.map_seeds)}; voxels of {RESOLUTION_M:g} m; rays up to {RANGE_M:g} m; "
            "launch argument volume:=true"
        ),
    )


def _table(flown: dict[str, list[dict]]) -> Table:
    rows = [(thesis.LIDARS[lidar].name, *_figures(results)) for lidar, results in flown.items()]
    return Table(
        "The hold in voxels",
        ("lidar", *(heading for heading, _, _ in COLUMNS.values())),
        rows,
        note="Median over the seeds. Surface is mapped if a voxel is occupied within one voxel of it. A "
        "perfect voxel's centre is half a voxel from its surface.",
    )


def _figures(results: Sequence[dict]) -> list[str]:
    with_least = [
        {**each, "least_mapped_share": min(each["mapped_share_by_part"].values())} for each in results
    ]
    return [
        number(factor * float(np.median([each[key] for each in with_least])), digits)
        for key, (_, factor, digits) in COLUMNS.items()
    ]


def _picture(lidar: str, result: dict) -> Picture:
    return Picture(
        result["pictures"][PICTURE].encode(),
        f"The hold in voxels by the {thesis.LIDARS[lidar].name}. Left: the map cut open, coloured by height, "
        "with the flown path. Right: sections, coloured by each voxel's distance from the true surface.",
        "Views and sections of the map of voxels, its distances from the true surface, and what is mapped",
        wide=True,
    )
