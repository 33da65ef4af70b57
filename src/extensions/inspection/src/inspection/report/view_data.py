"""What the page's viewer draws, as one JSON value."""

from __future__ import annotations

import base64
from typing import Any, Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.kinds import kind_of
from inspection.findings.merging import Finding
from inspection.report.scene import Scene
from inspection.report.sources import Shot
from inspection.report.views import Mark

STEPS = 65_000
"""Of 16 bits, along the longest side of the surface: 0.5 mm in 30 m."""


def view_data(
    scene: Scene | None,
    shots: Sequence[Shot],
    camera: SurveyCamera | None,
    findings: Sequence[Finding],
    marks: Sequence[Mark],
    best: Mapping[int, Mark],
) -> dict[str, Any]:
    """Return surface, photographs and findings; places in m, in the map."""
    extents = camera.half_extents if camera else (0.58, 0.43)
    of_shot: dict[int, list] = {k: [] for k in range(len(shots))}
    for mark in marks:
        of_shot[mark.photograph].append(
            [mark.finding, round(mark.centre[0], 4), round(mark.centre[1], 4), round(mark.radius, 4)]
        )
    return {
        "surface": None if scene is None else _surface(scene),
        "extents": [round(v, 4) for v in extents],
        "photographs": [_photograph(k, shot, of_shot[k]) for k, shot in enumerate(shots)],
        "colours": {kind: kind_of(kind).page_colour_hex for kind in sorted({each.kind for each in findings})},
        "findings": [
            {
                "id": each.id,
                "kind": each.kind,
                "status": each.status,
                "at": [round(v, 3) for v in each.position_m],
                "normal": [round(v, 3) for v in each.normal],
                "photograph": best[each.id].photograph if each.id in best else None,
            }
            for each in findings
        ],
    }


def _photograph(number: int, shot: Shot, marks: list) -> dict[str, Any]:
    axes = Rotation.from_quat(shot.record.orientation_xyzw).as_matrix()
    return {
        "name": shot.path.name,
        "number": number + 1,
        "at": [round(v, 3) for v in shot.record.position_m],
        "axes": np.round(axes.T, 4).ravel().tolist(),
        "marks": marks,
    }


def _surface(scene: Scene) -> dict[str, Any]:
    corners = scene.triangles_m.reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    step_m = float((high - low).max()) / STEPS
    whole = np.rint((corners - low) / step_m).astype("<u2")
    places, numbers = np.unique(whole, axis=0, return_inverse=True)
    return {
        "low": [round(float(v), 4) for v in low],
        "high": [round(float(v), 4) for v in high],
        "step": step_m,
        "places": _text(places),
        "corners": _text(numbers.ravel().astype("<u4")),
        "states": _text(scene.states.astype(np.uint8)),
        "edges": _text((scene.edges_m - low).astype("<f4")),
    }


def _text(values: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")
