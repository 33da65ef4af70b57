"""The file of defects beside a world: what is wrong with its surfaces, and what only looks so."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from flight_basics.checks import check_limits, limited
from input_schemas import read_file
from simulation_tools.camera.effects.amounts import Effects
from simulation_tools.camera.errors import PhotographError
from simulation_tools.camera.surfaces import Surfaces

KINDS = ("rust", "crack", "seam", "stain", "shadow")
"""rust and cracks are defects; seams, stains and shadows are none."""
NODES = 65
"""Points of a crack's line."""


@dataclass(frozen=True)
class Defect:
    """One mark on a surface. position_m: its middle, in the world. normal, along: unit vectors there.

    length_m, width_m: along `along` and across it. seed: of its shape.

    Raises:
        PhotographError: the kind is unknown, or a number makes no sense.
    """

    kind: str
    position_m: tuple[float, float, float]
    normal: tuple[float, float, float]
    along: tuple[float, float, float]
    length_m: float = limited(MISSING, above=0.0)
    width_m: float = limited(MISSING, above=0.0)
    seed: int = 0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise PhotographError(f'A defect is of the kind "{self.kind}"; give one of {", ".join(KINDS)}.')
        check_limits(self, PhotographError, f"A {self.kind}'s {{}}")


@dataclass(frozen=True)
class DefectFile:
    """The defects of a world, and the colours of its coatings, sRGB 0..1, by the model's name.

    effects: that its photographs show, too. world, seed: for which and with which the file was made.
    """

    defects: tuple[Defect, ...]
    coatings: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    effects: Effects = field(default_factory=Effects)
    world: str = ""
    seed: int = 0


class Decals(NamedTuple):
    """Marks as the kernels need them; those of one face stand together.

    first: (faces + 1,). kind: (n,). place: (n, 6): u, v of the middle, m; cosine and sine of the direction;
    half length and half width, m. shift: (n, 2) of the noise, texels. lines: (n, NODES) of cracks, m.
    """

    first: np.ndarray
    kind: np.ndarray
    place: np.ndarray
    shift: np.ndarray
    lines: np.ndarray


def beside(world: Path) -> Path:
    """Return where the defects of a world stand: NAME.defects.yaml beside NAME.world."""
    return world.with_suffix(".defects.yaml")


def defects_in(world: Path, given: Path | None) -> tuple[DefectFile, str]:
    """Return the defects of a world, and a sentence if there are none.

    given: their file; None: the one beside the world, if there is one.

    Raises:
        PhotographError: the file cannot be read, or an entry makes no sense.
    """
    path = given or beside(world)
    if given is None and not path.exists():
        return DefectFile((), {}), (
            f"{world.name} has no defects, so its photographs show none: there is no {path}. "
            f"This writes one: rosrun flights make_defects {world}"
        )
    return read_defects(path), ""


def read_defects(path: Path) -> DefectFile:
    """Read a file of defects.

    Raises:
        PhotographError: it cannot be read, or an entry makes no sense.
    """
    return read_file(path, "The defects", DefectFile, PhotographError)


def decals_of(defects: tuple[Defect, ...], surfaces: Surfaces) -> Decals:
    """Put marks onto the faces that they lie on, within 5 mm. One that lies on none is left out."""
    found = []
    for defect in defects:
        for face in _faces_of(defect, surfaces):
            found.append((face, defect))
    found.sort(key=lambda pair: pair[0])
    first = np.searchsorted([face for face, _ in found], np.arange(len(surfaces.offsets_m) + 1))
    n = max(len(found), 1)
    decals = Decals(
        first.astype(np.int32),
        np.zeros(n, np.int32),
        np.zeros((n, 6), np.float32),
        np.zeros((n, 2), np.float32),
        np.zeros((n, NODES), np.float32),
    )
    for row, (face, defect) in enumerate(found):
        u, v = surfaces.u_axes[face], surfaces.v_axes[face]
        decals.kind[row] = KINDS.index(defect.kind)
        direction = np.array((u @ defect.along, v @ defect.along))
        direction /= max(np.linalg.norm(direction), 1e-9)
        decals.place[row, :2] = u @ defect.position_m, v @ defect.position_m
        decals.place[row, 2:] = *direction, 0.5 * defect.length_m, 0.5 * defect.width_m
        rng = np.random.default_rng(defect.seed)
        decals.shift[row] = rng.uniform(0.0, 1000.0, 2)
        decals.lines[row] = _line(defect.length_m, rng)
    return decals


def _faces_of(defect: Defect, surfaces: Surfaces) -> np.ndarray:
    """Faces in the mark's plane."""
    near = np.abs(surfaces.normals @ defect.position_m - surfaces.offsets_m) < 5e-3
    return np.flatnonzero(near & (surfaces.normals @ defect.normal > 0.99))


def _line(length_m: float, rng: np.random.Generator) -> np.ndarray:
    """Return how far a crack is beside its straight line, m: a random walk that is 0 at both ends."""
    walk = np.cumsum(rng.standard_normal(NODES)) * 0.3 * length_m / NODES
    return walk - np.linspace(walk[0], walk[-1], NODES)
