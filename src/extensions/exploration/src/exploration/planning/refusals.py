"""One sentence that says why there is no path, and what blocks it."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning.if_free import clearances_if_free
from exploration.planning.kernels.search import UNREACHED
from exploration.planning.kernels.widest import narrowest_place
from exploration.planning.space import Space
from exploration.planning.voxel_grid import OCCUPIED
from flight_basics.errors import NoPathError


def require_start(space: Space, start_m: np.ndarray) -> None:
    """Raise NoPathError if the UAV is in an obstacle, in unknown space or in a keep-out box."""
    blocker = _blocker(space, start_m)
    if blocker:
        raise NoPathError(f"The start {_at(start_m)} is in {blocker}.")


def require_goal(space: Space, goal_m: np.ndarray) -> None:
    """Raise NoPathError if the UAV may not be at the goal, or has no room there."""
    if goal_m[2] > space.limits.ceiling_m:
        raise NoPathError(f"The goal {_at(goal_m)} is above the ceiling of {space.limits.ceiling_m:g} m.")
    blocker = _blocker(space, goal_m)
    index = space.grid.index_of(goal_m)
    if blocker or index is None:
        raise NoPathError(f"The goal {_at(goal_m)} is in {blocker}.")
    square = int(space.squares[index])
    if square < space.need:
        place_m = _nearest_blocked_m(space, index, square)
        raise NoPathError(
            f"The goal {_at(goal_m)} is {_metres(space, square)} m from {_blocker(space, place_m)}, but the "
            f"UAV needs {space.clearance_m:.2f} m."
        )


def closed_ways(space: Space) -> str:
    """Return the sentence for ways that are all closed."""
    first = min(space.closed, key=lambda closure: closure.until_s)
    return (
        f"Every way is closed, because CEPA did not fly it; the first opens again near {_at(first.place_m)}."
    )


def no_way(space: Space, came: np.ndarray, goal_m: np.ndarray) -> str:
    """Return the sentence for a goal that the start does not reach, by what it reaches (`came`)."""
    narrow = _too_narrow(space, came, goal_m)
    if narrow:
        return narrow
    reached_m = space.grid.centres_m(np.argwhere(came != UNREACHED))
    away_m = np.linalg.norm(reached_m - goal_m, axis=1)
    nearest_m = reached_m[away_m.argmin()]
    return (
        f"No known free way leads to {_at(goal_m)}: the UAV comes closest at {_at(nearest_m)}, "
        f"{away_m.min():.1f} m before it, and then meets {_first_blocker(space, nearest_m, goal_m)}."
    )


def _too_narrow(space: Space, came: np.ndarray, goal_m: np.ndarray) -> str:
    """Return the sentence for a way that is free, but too narrow; an empty text: none is free.

    What is known to be in the way counts first: behind a door, what is seen through it alone is as narrow.
    """
    goal = np.array(space.grid.index_of(goal_m))
    if_free = np.where(space.squares > 0, clearances_if_free(space, math.isqrt(space.need - 1) + 1), 0)
    for squares, beside in ((if_free.astype(np.uint16), ""), (space.squares, " beside what is unknown")):
        narrowest = narrowest_place(squares, came, goal)
        if narrowest < 0:
            return ""
        index = np.array(np.unravel_index(narrowest, squares.shape))
        square = int(squares[tuple(index)])
        if square < space.need:
            return (
                f"The way to {_at(goal_m)} is too narrow at {_at(space.grid.centres_m(index[None])[0])}: a "
                f"UAV may need {_metres(space, square)} m to each side there{beside}, "
                f"but this one needs {space.clearance_m:.2f} m."
            )
    return ""


def _blocker(space: Space, place_m: np.ndarray) -> str:
    """Return what makes a place impassable, or an empty text."""
    grid = space.grid
    for box in space.limits.boxes:
        if box.holds(place_m):
            return f"the keep-out box {box.name}".rstrip()
    index = grid.index_of(place_m)
    if index is None or not grid.is_free(index):
        is_occupied = index is not None and grid.kinds[index] == OCCUPIED
        return "an obstacle" if is_occupied else "unknown space"
    for closure in space.closed:
        if math.dist(closure.place_m, place_m) <= closure.radius_m:
            return "a place that is closed, because CEPA did not fly there"
    if space.far is not None and space.far[index]:
        return "a place too far from all that tells the lidar where it is"
    if not space.squares[index]:
        centre_m = grid.centres_m(np.array(index)[None])[0]
        return (
            "a voxel that reaches above the ceiling"
            if centre_m[2] > space.limits.ceiling_m
            else ("a voxel that reaches into a keep-out box")
        )
    return ""


def _nearest_blocked_m(space: Space, index: tuple[int, int, int], square: int) -> np.ndarray:
    """Return the centre of a blocked voxel at this squared distance."""
    reach = math.isqrt(square)
    axis = np.arange(-reach, reach + 1)
    offsets = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    offsets = offsets[(offsets**2).sum(axis=1) == square]
    places_m = space.grid.centres_m(np.array(index) + offsets)
    return next((place_m for place_m in places_m if _blocker(space, place_m)), places_m[0])


def _first_blocker(space: Space, begin_m: np.ndarray, end_m: np.ndarray) -> str:
    """Return what blocks the straight way first."""
    count = 2 + int(2.0 * math.dist(begin_m, end_m) / space.grid.resolution_m)
    for share in np.linspace(0.0, 1.0, count):
        blocker = _blocker(space, begin_m + share * (end_m - begin_m))
        if blocker:
            return blocker
    return "a turn that it cannot take"


def _metres(space: Space, square: int) -> str:
    return f"{math.sqrt(square) * space.grid.resolution_m:.2f}"


def _at(place_m: np.ndarray | tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{v:.1f}" for v in place_m) + ")"
