"""A flight's commanded and measured velocities, for identifying how the UAV responds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cepa.errors import CepaError

STEP_S = 0.01
LONGEST_GAP_S = 0.5
"""A longer gap between messages parts a recording; after it nobody knows what was flown."""
SHORTEST_PIECE_S = 4.0


class IdentificationError(CepaError):
    """A recording that does not tell how the UAV responds."""


@dataclass(frozen=True, eq=False)
class Recording:
    """Commanded and measured velocities along the odometry's axes.

    Raises IdentificationError for rows that are not finite numbers.
    """

    commands: np.ndarray
    """(n, 4): s, m/s ahead, left, up; each holds until the next."""
    velocities: np.ndarray
    """(m, 4): the same of the UAV, as measured."""

    def __post_init__(self) -> None:
        for name, unit in (("commands", "commanded"), ("velocities", "measured")):
            rows = np.asarray(getattr(self, name), dtype=np.float64)
            if rows.ndim != 2 or rows.shape[1] != 4 or not np.isfinite(rows).all():
                raise IdentificationError(f"The {unit} velocities must be finite rows of t, vx, vy, vz.")
            _, first = np.unique(rows[:, 0], return_index=True)
            object.__setattr__(self, name, rows[first])


@dataclass(frozen=True, eq=False)
class Piece:
    """An uninterrupted part of a recording, every STEP_S."""

    times_s: np.ndarray
    """(n,)"""
    commands: np.ndarray
    """(n, 3) m/s"""
    velocities: np.ndarray
    """(n, 3) m/s"""


def pieces_of(recording: Recording) -> list[Piece]:
    """Return what is between gaps, on one grid of time. Raises IdentificationError if nothing is left."""
    commands, velocities = recording.commands, recording.velocities
    times = [rows[:, 0] for rows in (commands, velocities)]
    if min(map(len, times)) < 2:
        raise IdentificationError(
            f"The recording holds {len(times[0])} commands and {len(times[1])} measured velocities; "
            "check the topics."
        )
    grid = np.arange(max(t[0] for t in times), min(t[-1] for t in times), STEP_S)
    known = np.ones(grid.size, bool)
    for t in times:
        following = np.clip(np.searchsorted(t, grid, side="right"), 1, t.size - 1)
        known &= t[following] - t[following - 1] <= LONGEST_GAP_S
    edges = np.flatnonzero(np.diff(np.concatenate(([False], known, [False])).astype(int)))
    pieces: list[Piece] = []
    for first, end in edges.reshape(-1, 2):
        if (end - first) * STEP_S < SHORTEST_PIECE_S:
            continue
        t = grid[first:end]
        held = commands[np.searchsorted(times[0], t + 1e-9, side="right") - 1, 1:]
        measured = np.stack([np.interp(t, times[1], velocities[:, axis]) for axis in (1, 2, 3)], axis=1)
        pieces.append(Piece(t, held, measured))
    if not pieces:
        raise IdentificationError(
            f"Commands and measured velocities never last {SHORTEST_PIECE_S:g} s together without a gap of "
            f"{LONGEST_GAP_S:g} s; check the topics, or record longer."
        )
    return pieces
