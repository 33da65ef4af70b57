"""What a source of poses tells of the photographs of a folder."""

from __future__ import annotations

import unicodedata
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from flight_basics.geometry import Quaternion, Vector3
from inspection.camera.survey_camera import SurveyCamera
from inspection.photographs.listing import LeftOut


@dataclass(frozen=True)
class Pose:
    """Of the optical frame (x right, y down, z ahead) in the map; exposure_s, iso, lux: None: not known."""

    position_m: Vector3
    orientation_xyzw: Quaternion
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
    sentences on their accuracy.
    """

    of: Mapping[Path, Pose] = field(default_factory=dict)
    left_out: tuple[LeftOut, ...] = ()
    camera: SurveyCamera | None = None
    is_camera_exact: bool = False
    remarks: tuple[str, ...] = ()


class Names:
    """Finds photographs by the names that tables and models of other tools give them."""

    def __init__(self, folder: Path, photographs: Sequence[Path]) -> None:
        self._folder = folder
        self._by_name = {_letters(each.name): each for each in photographs}
        self._by_word = _alone([(_letters(each.name).lower(), each) for each in photographs])
        self._by_stem = _alone([(_letters(each.stem).lower(), each) for each in photographs])

    def find(self, told: str) -> Path | None:
        """Return the photograph; None: it is not in the folder. Folders before a name do not count."""
        name = _letters(told.replace("\\", "/").rsplit("/", 1)[-1])
        word = name.lower()
        return self._by_name.get(name) or self._by_word.get(word) or self._by_stem.get(word)


def _letters(name: str) -> str:
    """Return a name in one way to write letters with marks: macOS stores "ü" as "u" and a mark."""
    return unicodedata.normalize("NFC", name)


def _alone(named: Sequence[tuple[str, Path]]) -> dict[str, Path]:
    """Return the photographs whose name no other one has."""
    counts = Counter(name for name, _ in named)
    return {name: path for name, path in named if counts[name] == 1}
