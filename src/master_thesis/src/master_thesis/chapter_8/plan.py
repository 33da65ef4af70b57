"""All pieces of the report, and the choice of some."""

from __future__ import annotations

from typing import Sequence

from master_thesis.experiment_1 import pieces as experiment_1
from master_thesis.experiment_2 import pieces as experiment_2
from master_thesis.experiments_3_4.report import pieces as experiments_3_4
from master_thesis.experiments_3_4.volume import pieces as volume
from master_thesis.experiments_3_4.without_gnss import pieces as without_gnss
from master_thesis.exploring import pieces as exploration
from master_thesis.measurements import pieces as measurements
from master_thesis.report.piece import Piece
from master_thesis.report.size import Size


def plan(size: Size) -> list[Piece]:
    """Return every piece of a report of this size."""
    return [
        piece
        for kind in (
            experiment_1,
            experiment_2,
            experiments_3_4,
            volume,
            without_gnss,
            exploration,
            measurements,
        )
        for piece in kind.pieces(size)
    ]


def chosen(pieces: Sequence[Piece], only: Sequence[str], lidars: Sequence[str]) -> list[Piece]:
    """Return the pieces of some experiments and some lidars; an empty choice means all."""
    return [
        piece
        for piece in pieces
        if (not only or piece.experiment in only)
        and (not lidars or piece.lidar is None or piece.lidar in lidars)
    ]
