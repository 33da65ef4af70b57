"""Openings that a UAV sees through, but is too wide for: where they are, how wide, and what lies behind."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Mapping, NamedTuple, Sequence

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from exploration.next_view.unknown_room import TOUCHING, joined
from exploration.planning import FREE, UNKNOWN, PlannerParameters
from exploration.planning.if_free import clearances_if_free
from exploration.planning.kernels.search import START, UNREACHED
from exploration.planning.kernels.widest import narrowest_place
from exploration.planning.space import LEAST_NEED, Space
from flight_basics.checks import check_number
from flight_basics.errors import ParameterError

NARROWEST_M = 0.3
"""A gap that is narrower counts as a crack: no UAV is so small."""
BORDER_MIN_M2 = 0.5
"""Behind an opening, so much of the border of what is known is worth a word."""
SAME_M = 1.0
"""Openings that are nearer to each other are one."""
WIDER = 1.5
"""Voxels by which room is wider to each side than an opening that leads to it: noise makes one of them."""
STEPS = 4
"""From what stays unknown to known free space with some room around it, voxels."""
FACES = ((0, 0, 1), (0, 0, -1), (0, 1, 0), (0, -1, 0), (1, 0, 0), (-1, 0, 0))


@dataclass(frozen=True)
class Opening:
    """An opening that is too narrow.

    place_m: (x, y, z) in it, in the map's frame. width_m: its least side, right to a voxel of side voxel_m.
    needed_m: the width that this UAV needs on this map. passing: words for what would pass,
    empty if nothing is known.
    """

    place_m: tuple[float, float, float]
    width_m: float
    voxel_m: float
    needed_m: float
    passing: str = ""

    def __str__(self) -> str:
        at = ", ".join(f"{v:.1f}" for v in self.place_m)
        wide = f"is about {self.width_m:.1f} m wide (map of {self.voxel_m:g} m)"
        told = f"the opening at ({at}) {wide}, this UAV needs {self.needed_m:.1f} m"
        return f"{told}; {self.passing}" if self.passing else told


class Behind(NamedTuple):
    """What lies behind narrow openings.

    openings: each once. part: (d, h, w) number of the opening behind which a free voxel lies, from 1; 0: it
    lies before all of them, or is not free, or close to a wall.
    """

    openings: tuple[Opening, ...]
    part: np.ndarray

    def opening_of(self, space: Space, voxel: Sequence[int]) -> Opening | None:
        """Return the opening behind which an unknown voxel (z, y, x) of the border lies; None: none."""
        if not self.openings:
            return None
        voxels, met = [tuple(voxel)], {tuple(voxel)}
        for _ in range(STEPS):
            beside = {tuple(np.add(at, step).tolist()) for at, step in product(voxels, FACES)} - met
            voxels = [at for at in sorted(beside) if _is_free(space, at)]
            numbers = {int(self.part[at]) for at in voxels} - {0}
            if numbers:
                number = min(numbers)
                return None if number == BEFORE else self.openings[number - 1]
            met |= beside
        return None


BEFORE = 255
"""In `Behind.part`: where the UAV itself comes to."""


def radii_of(given: object) -> dict[str, float]:
    """Return the radii of UAVs by name, m, from a parameter's value.

    Raises:
        ParameterError: it is no mapping from names to radii.
    """
    if not isinstance(given, Mapping):
        raise ParameterError(f"smaller_uavs is {given!r}; give radii in metres by name: {{small_quad: 0.2}}.")
    for name, radius_m in given.items():
        check_number(f"smaller_uavs/{name}", radius_m, 0.01, 5.0)
    return {str(name): float(radius_m) for name, radius_m in given.items()}


def narrow_openings(
    space: Space, nodes: np.ndarray, parameters: PlannerParameters, smaller: Mapping[str, float]
) -> Behind:
    """Return the openings in known free space that only a smaller UAV would fit through.

    Args:
        space: what the UAV may fly through.
        nodes: (n, 3) voxels of the map where it can be, z, y, x.
        parameters: of the UAV.
        smaller: radii of other UAVs by name, m.
    """
    reach = math.isqrt(space.need - 1) + 1
    squares = np.where(space.grid.kinds == FREE, clearances_if_free(space, reach), 0)
    least = max((0.5 * NARROWEST_M / space.grid.resolution_m) ** 2, 1.0)  # of coarse voxels, two free ones
    if not len(nodes) or least >= space.need:
        return Behind((), np.zeros(squares.shape, np.uint8))
    own = joined(squares >= space.need, nodes)
    own[tuple(nodes.T)] = True
    fringe = ndimage.binary_dilation(own, TOUCHING, iterations=reach)
    passable = squares >= least
    pieces, count = ndimage.label(joined(passable, nodes) & ~fringe, TOUCHING)
    came = np.where(own, START, UNREACHED).astype(np.int8)
    on_way = np.where(passable | own, squares, 0).astype(np.uint16)
    found: list[Opening] = []
    of_piece: dict[int, int] = {}
    border_m2 = _borders_m2(space, pieces, count)
    for piece in 1 + np.argsort(-border_m2, kind="stable"):
        if border_m2[piece - 1] < BORDER_MIN_M2:
            break
        narrowest = narrowest_place(on_way, came, _room_next_to(own, squares, pieces == piece))
        if narrowest < 0:
            continue
        voxel = np.array(np.unravel_index(narrowest, squares.shape))
        if not _leads_on(space, squares, pieces == piece, voxel):
            continue
        opening = _opening(space, voxel, int(squares[tuple(voxel)]), parameters, smaller)
        known = [n for n, other in enumerate(found) if math.dist(other.place_m, opening.place_m) < SAME_M]
        if not known:
            found.append(opening)
        of_piece[int(piece)] = known[0] + 1 if known else len(found)
    return Behind(tuple(found), _parts(space, squares, own, pieces, of_piece, found))


def _leads_on(space: Space, squares: np.ndarray, piece: np.ndarray, voxel: np.ndarray) -> bool:
    """Return whether something lies behind an opening, and it is no niche.

    That is room in the piece of free space behind it that is wider. Or straight on, most lines through the
    opening end before what is unknown, and not before a wall.
    """
    wider = math.ceil((math.sqrt(squares[tuple(voxel)]) + WIDER) ** 2)
    if (squares[piece] >= min(wider, space.need)).any():
        return True
    axis, section = _section(space, voxel)
    is_ahead = np.argwhere(piece)[:, axis].mean() > voxel[axis]
    kinds = np.moveaxis(space.grid.kinds, axis, -1)[tuple(section.T)]
    ahead = kinds[:, voxel[axis] :] if is_ahead else kinds[:, voxel[axis] :: -1]
    ahead = np.pad(ahead, ((0, 0), (0, 1)), constant_values=UNKNOWN)  # all outside the map
    ends = ahead[np.arange(len(ahead)), (ahead != FREE).argmax(axis=1)]
    return bool((ends == UNKNOWN).mean() > 0.5)


def _room_next_to(own: np.ndarray, squares: np.ndarray, piece: np.ndarray) -> np.ndarray:
    """Return the voxel (3,) of a piece of free space with most room that is nearest to the UAV's own places.

    The way there is short, so that its narrowest place is the opening's.
    """
    roomy = np.argwhere(piece & (squares == squares[piece].max()))
    apart, _ = cKDTree(np.argwhere(own)).query(roomy)
    nearest: np.ndarray = roomy[apart.argmin()]
    return nearest


def _borders_m2(space: Space, pieces: np.ndarray, count: int) -> np.ndarray:
    """Return (count,) the area of the border of what is known, at each piece of free space."""
    spread = ndimage.grey_dilation(pieces, footprint=ndimage.generate_binary_structure(3, 1))
    at_border = np.bincount(spread[space.grid.kinds == UNKNOWN], minlength=count + 1)[1:]
    areas: np.ndarray = at_border * space.grid.resolution_m**2
    return areas


def _opening(
    space: Space, voxel: np.ndarray, square: int, parameters: PlannerParameters, smaller: Mapping[str, float]
) -> Opening:
    side_m, needed_m = space.grid.resolution_m, 2.0 * space.clearance_m
    half_m = math.sqrt(square) * side_m
    width_m = _width_m(space, voxel)
    if not width_m < needed_m:
        width_m = 2.0 * half_m
    x, y, z = space.grid.centres_m(voxel[None])[0].tolist()
    fits = {name for name, radius_m in smaller.items() if radius_m < parameters.radius}
    ways = [f"model:={name}" for name in sorted(fits) if 2.0 * smaller[name] <= width_m]
    margin_m = math.floor(100.0 * (half_m - parameters.radius) + 1e-6) / 100.0
    if 0.0 <= margin_m < parameters.margin:
        ways.append(f"margin:={margin_m:g} instead of {parameters.margin:g}")
    passing = f"{' or '.join(ways)} would fit" if ways else ""
    return Opening((x, y, z), width_m, side_m, needed_m, passing)


def _width_m(space: Space, voxel: np.ndarray) -> float:
    """Return the least side of the opening's cross-section at a voxel, m.

    An edge lies somewhere in the occupied voxels on both sides: on average, half of each belongs to the
    opening.
    """
    _, own = _section(space, voxel)
    return float((np.ptp(own, axis=0) + 2).min()) * space.grid.resolution_m


def _section(space: Space, voxel: np.ndarray) -> tuple[int, np.ndarray]:
    """Return the axis along which the way leads through an opening at a voxel, and the section across it.

    It is the axis on which most is free. The section are the indices (n, 2) along the other two axes.
    """
    is_free = space.grid.kinds == FREE
    ways = [_run(is_free[tuple(np.s_[:] if a == axis else v for a, v in enumerate(voxel))], voxel[axis])
            for axis in range(3)]  # fmt: skip
    axis = int(np.argmax(ways))
    labels, _ = ndimage.label(np.take(is_free, voxel[axis], axis=axis))
    return axis, np.argwhere(labels == labels[tuple(np.delete(voxel, axis))])


def _run(line: np.ndarray, at: int) -> int:
    """Return how many voxels are free in one piece on a line (n,) about a place."""
    labels, _ = ndimage.label(line)
    return int((labels == labels[at]).sum())


def _parts(
    space: Space,
    squares: np.ndarray,
    own: np.ndarray,
    pieces: np.ndarray,
    of_piece: Mapping[int, int],
    openings: Sequence[Opening],
) -> np.ndarray:
    """Return `Behind.part`: free space falls into parts when the openings are filled."""
    is_open = squares >= LEAST_NEED
    middles = np.array([space.inner(np.array(opening.place_m)) for opening in openings]).reshape(-1, 3)
    for middle, opening in zip(middles, openings):
        reach = opening.needed_m / 2.0 / space.grid.resolution_m + 1.0
        low = np.maximum(np.floor(middle - reach).astype(int), 0)
        part = is_open[tuple(slice(a, b) for a, b in zip(low, np.ceil(middle + reach).astype(int)))]
        axes = [(np.arange(size) + a + 0.5 - c) ** 2 for size, a, c in zip(part.shape, low, middle)]
        part[axes[0][:, None, None] + axes[1][:, None] + axes[2] <= reach**2] = False
    labels, count = ndimage.label(is_open, TOUCHING)
    number = np.zeros(count + 1, np.uint8)
    for piece, opening_number in of_piece.items():
        number[labels[pieces == piece]] = opening_number
    number[labels[own]] = BEFORE
    number[0] = 0
    parts: np.ndarray = number[labels]
    return parts


def _is_free(space: Space, voxel: tuple[int, ...]) -> bool:
    inside = all(0 <= v < size for v, size in zip(voxel, space.grid.kinds.shape))
    return inside and bool(space.grid.kinds[voxel] == FREE)
