"""Which photograph shows which finding, and where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.merging import Finding
from inspection.report.sources import Shot


@dataclass(frozen=True)
class Mark:
    """A finding in a photograph. centre: its place as shares 0..1 of width and height. radius: of width.

    per_m: widths of the photograph that a metre across the line of sight takes there.
    """

    finding: int
    photograph: int
    centre: tuple[float, float]
    radius: float
    worth: float
    per_m: float


def marks_of(findings: Sequence[Finding], shots: Sequence[Shot], camera: SurveyCamera) -> list[Mark]:
    """Return each finding in each photograph that names it; worth: greater where it is seen finer."""
    number_of = {shot.path.name: k for k, shot in enumerate(shots)}
    marks = []
    for each in findings:
        for k in sorted({number_of[name] for name in each.photographs if name in number_of}):
            mark = _mark(each, k, shots[k], camera)
            if mark is not None:
                marks.append(mark)
    return marks


def best_of(marks: Sequence[Mark]) -> dict[int, Mark]:
    """Return the mark with the greatest worth, by finding."""
    best: dict[int, Mark] = {}
    for mark in marks:
        if mark.finding not in best or mark.worth > best[mark.finding].worth:
            best[mark.finding] = mark
    return best


def _mark(finding: Finding, number: int, shot: Shot, camera: SurveyCamera) -> Mark | None:
    turn = Rotation.from_quat(shot.record.orientation_xyzw).as_matrix()
    towards = np.array(finding.position_m) - np.array(shot.record.position_m)
    right, down, ahead = towards @ turn
    if ahead <= 0.05:
        return None
    size = (camera.width, camera.height)
    (at,), _ = camera.drawn(np.array([(right, down, ahead)]))
    x, y = (float(v / s) for v, s in zip(at, size))
    if not (-0.02 <= x <= 1.02 and -0.02 <= y <= 1.02):
        return None
    away_m = float(np.linalg.norm(towards))
    facing = max(-float(towards @ np.array(finding.normal)) / away_m, 0.05)
    inside = min(x, y, 1.0 - x, 1.0 - y) > 0.04
    radius_px = max(0.6 * finding.length_m * camera.focal_px / ahead, 20.0)
    return Mark(
        finding.id,
        number,
        (x, y),
        radius_px / camera.width,
        facing / away_m * (1.0 if inside else 0.3),
        camera.focal_px / ahead / camera.width,
    )
