"""What a source of poses tells of the photographs of a folder."""

from __future__ import annotations

import math
import unicodedata
from collections import Counter, defaultdict
from dataclasses import dataclass, field, replace
from itertools import takewhile
from pathlib import Path
from typing import Iterable, Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from flight_basics.geometry import Quaternion, Vector3
from inspection.camera.survey_camera import SurveyCamera
from inspection.photographs.listing import LeftOut
from inspection.photographs.record import PhotographError
from inspection.photographs.sourced import Doubt, Sourced, best_of


@dataclass(frozen=True)
class Pose:
    """Of the optical frame (x right, y down, z ahead) in the map; exposure_s, iso, lux: None: not known.

    source: in words. deviation, turned_rad: standard deviations of the place, m, and of the direction; 0: the
    source does not tell them.
    """

    position_m: Vector3
    orientation_xyzw: Quaternion
    source: str = ""
    deviation: float = 0.0
    turned_rad: float = 0.0
    stamp_s: float | None = None
    exposure_s: float | None = None
    iso: float | None = None
    lux: float | None = None

    @classmethod
    def of_axes(cls, position_m: Sequence[float] | np.ndarray, axes: np.ndarray) -> Pose:
        """Return the pose of a camera; axes: (3, 3), the optical frame's in its columns."""
        x, y, z = (float(each) for each in position_m)
        qx, qy, qz, qw = Rotation.from_matrix(axes).as_quat().tolist()
        return cls((x, y, z), (qx, qy, qz, qw))


@dataclass(frozen=True)
class Poses:
    """Poses by photograph.

    camera: None: the source does not tell it. is_camera_exact: the poses hold with this camera only. remarks:
    sentences on their accuracy. doubts: by the photograph's name.
    """

    of: Mapping[Path, Pose] = field(default_factory=dict)
    left_out: tuple[LeftOut, ...] = ()
    camera: Sourced[SurveyCamera] | None = None
    is_camera_exact: bool = False
    remarks: tuple[str, ...] = ()
    doubts: tuple[tuple[str, Doubt], ...] = ()


ONE_CAMERA = 0.04
"""The lines of sight of one camera differ by less at depth 1, wherever they meet its pictures. Chosen.

COLMAP finds the lens anew for each picture; a zoom lens that was moved is another camera.
"""


def one_camera(
    told: Mapping[Path, Sourced[SurveyCamera]],
) -> tuple[Sourced[SurveyCamera] | None, list[LeftOut]]:
    """Return the camera of most pictures, and those that were taken with another one.

    Of those of one size that are alike, it is that of the middle focal length. Its deviation is theirs.
    """
    if not told:
        return None, []
    sizes = Counter((each.value.width, each.value.height) for each in told.values())
    size = max(sizes, key=sizes.__getitem__)
    own = [each for each in told.values() if (each.value.width, each.value.height) == size]
    own.sort(key=lambda each: each.value.focal_px)
    logs = np.log([each.value.focal_px for each in own])
    counts = np.searchsorted(logs, logs + ONE_CAMERA, "right") - np.searchsorted(logs, logs - ONE_CAMERA)
    best = np.flatnonzero(counts == counts.max())
    middle = own[int(best[len(best) // 2])]
    grid = np.meshgrid(*(np.linspace(0.0, side - 1.0, 5) for side in size))
    pixels = np.column_stack([each.ravel() for each in grid])
    rays = {each: each.rays(pixels) for each in {each.value for each in own}}
    alike = {each for each, held in rays.items() if np.abs(held - rays[middle.value]).max() <= ONE_CAMERA}
    left_out = [
        LeftOut(path.name, "It was taken with another camera or zoom than most. Give it a folder of its own.")
        for path, each in told.items()
        if each.value not in alike
    ]
    spread = float(np.std([np.log(each.value.focal_px) for each in own if each.value in alike]))
    return Sourced(middle.value, middle.source, max(middle.deviation, spread)), left_out


def checked_by(poses: Poses, others: Poses) -> Poses:
    """Return poses with a doubt for each that others contradict."""
    doubts = list(poses.doubts)
    for path, pose in poses.of.items():
        if path in others.of:
            _, said = best_of((pose, others.of[path]), _apart_m, "the place", _place_in_words)
            doubts += [(path.name, each) for each in said]
    return replace(poses, doubts=tuple(doubts))


def _apart_m(one: Pose, other: Pose) -> float:
    return math.dist(one.position_m, other.position_m)


def _place_in_words(pose: Pose) -> str:
    return "({:.2f}, {:.2f}, {:.2f})".format(*pose.position_m)


class Names:
    """Finds photographs by the names that a table or a model of another tool gives them.

    If these have folders before them, as of several flights, those count whose folder is called like ours.

    Attributes:
        remarks: a sentence, if the photographs have been found in several folders, none called like ours.

    Raises:
        PhotographError: one photograph could be several of them.
    """

    def __init__(self, folder: Path, photographs: Sequence[Path], told: Iterable[str], where: Path) -> None:
        self._by_name = {_letters(each.name): each for each in photographs}
        self._by_word = _alone([(_letters(each.name).lower(), each) for each in photographs])
        self._by_stem = _alone([(_letters(each.stem).lower(), each) for each in photographs])
        own = _folders(f"{folder.resolve()}/_")
        common = {each: _in_common(_folders(each), own) for each in told}
        most = max(common.values(), default=0)
        meant = defaultdict[Path, list[str]](list)
        for each, shared in common.items():
            path = self._look_up(each)
            if path is not None and (shared == most or not _folders(each)):
                meant[path].append(each)
        self._found = dict[str, Path]()
        for path, names in meant.items():
            others = [each for each in names if _folders(each) != _folders(names[0])]
            if others:
                raise PhotographError(
                    f"{where}: {path.name} could be {names[0]} or {others[0]}. Call the folder of "
                    "photographs like the folder of those that are meant."
                )
            exact = [each for each in names if _letters(_name(each)) == _letters(path.name)]
            self._found[(exact or names)[0]] = path
        of = sorted({_folders(each) for each in self._found}) if not most else []
        self.remarks = (
            (
                f"{where}: the photographs are of {len(of)} folders, the first {'/'.join(of[0])} and "
                f"{'/'.join(of[1])}. If they are of one of them, call {folder} like it, and run this again.",
            )
            if of[1:]
            else ()
        )

    def find(self, told: str) -> Path | None:
        """Return the photograph; None: it is not in the folder."""
        return self._found.get(told)

    def _look_up(self, told: str) -> Path | None:
        name = _letters(_name(told))
        word = name.lower()
        return self._by_name.get(name) or self._by_word.get(word) or self._by_stem.get(word)


def _name(told: str) -> str:
    return told.replace("\\", "/").rpartition("/")[2]


def _folders(told: str) -> tuple[str, ...]:
    """Return the folders in a name, in small letters."""
    return tuple(each for each in _letters(told.lower()).replace("\\", "/").split("/")[:-1] if each)


def _in_common(one: tuple[str, ...], other: tuple[str, ...]) -> int:
    """Return how many folders two ways have in common, from their ends."""
    pairs = zip(reversed(one), reversed(other))
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))


def _letters(name: str) -> str:
    """Return a name in one way to write letters with marks: macOS stores "ü" as "u" and a mark."""
    return unicodedata.normalize("NFC", name)


def _alone(named: Sequence[tuple[str, Path]]) -> dict[str, Path]:
    """Return the photographs whose name no other one has."""
    counts = Counter(name for name, _ in named)
    return {name: path for name, path in named if counts[name] == 1}
