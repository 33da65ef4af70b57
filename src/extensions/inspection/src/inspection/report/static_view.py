"""A picture of the surface, as through the nearer walls: for print and where there is no WebGL."""

from __future__ import annotations

import io
import math
from typing import Sequence

import numpy as np
from PIL import Image, ImageDraw

from inspection.findings.findings_file import DISMISSED
from inspection.findings.kinds import kind_of
from inspection.findings.merging import Finding
from inspection.report.scene import Scene
from inspection.survey.surface.rays import Rays
from inspection.survey.surface.samples import normals_of

COLOURS = np.array(((143, 184, 154), (232, 163, 61), (178, 184, 192), (170, 178, 190)), float)
"""sRGB of the states of `scene`: seen, open, out of reach, unknown; the page's viewer has the same."""
WIDTH_PX, HEIGHT_PX = 1200, 800
LAYERS = 8
"""Surfaces seen from behind that a ray passes at most."""


def static_view(
    scene: Scene, findings: Sequence[Finding], from_deg: float, up_deg: float = 32.0, closed: bool = True
) -> bytes:
    """Return a PNG of the surface, without perspective, from a direction: 0 looks along -x, from ahead.

    closed: triangles show one side only.
    """
    azimuth, height = math.radians(from_deg), math.radians(up_deg)
    back = np.array(
        (math.cos(height) * math.cos(azimuth), math.cos(height) * math.sin(azimuth), math.sin(height))
    )
    right = np.array((-math.sin(azimuth), math.cos(azimuth), 0.0))
    up = np.cross(back, right)
    corners = scene.triangles_m.reshape(-1, 3)
    spans = [(float((corners @ axis).min()), float((corners @ axis).max())) for axis in (right, up)]
    per_px = 1.04 * max((spans[0][1] - spans[0][0]) / WIDTH_PX, (spans[1][1] - spans[1][0]) / HEIGHT_PX)
    middle = [0.5 * (a + b) for a, b in spans]
    x, y = np.meshgrid(np.arange(WIDTH_PX) + 0.5, np.arange(HEIGHT_PX) + 0.5)
    across = (x.ravel() - 0.5 * WIDTH_PX) * per_px + middle[0]
    upwards = (0.5 * HEIGHT_PX - y.ravel()) * per_px + middle[1]
    far_m = float((corners @ back).max()) + 1.0
    origins = across[:, None] * right + upwards[:, None] * up + far_m * back
    colour, depth = _cast(scene, origins, -back, closed)
    picture = Image.fromarray(colour.reshape(HEIGHT_PX, WIDTH_PX, 3))
    depth = depth.reshape(HEIGHT_PX, WIDTH_PX)
    draw = ImageDraw.Draw(picture)
    for each in findings:
        if each.status != DISMISSED:
            place = np.array(each.position_m)
            px = (place @ right - middle[0]) / per_px + 0.5 * WIDTH_PX
            py = 0.5 * HEIGHT_PX - (place @ up - middle[1]) / per_px
            if _is_seen(depth, px, py, far_m - float(place @ back)):
                _draw_mark(draw, px, py, kind_of(each.kind).page_colour)
    out = io.BytesIO()
    picture.quantize(128).save(out, "PNG", optimize=True)
    return out.getvalue()


def _cast(scene: Scene, origins: np.ndarray, ray: np.ndarray, closed: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return colour (n, 3) uint8 and distance (n,) of the first triangle that faces the eye."""
    rays = Rays(scene.triangles_m)
    normals, _ = normals_of(scene.triangles_m)
    towards = -(normals @ ray)
    colour = np.full((len(origins), 3), 255, np.uint8)
    depth = np.full(len(origins), np.inf)
    left, begun = np.arange(len(origins)), np.zeros(len(origins))
    for _ in range(LAYERS):
        start = origins[left] + begun[left, None] * ray
        met, far_m = rays.hits(start, np.broadcast_to(ray, start.shape))
        hit = met >= 0
        meeting, triangles = left[hit], met[hit]
        begun[meeting] += far_m[hit] + 2e-3
        faces = towards[triangles] > 0.0 if closed else np.ones(len(triangles), bool)
        shade = 0.72 + 0.28 * np.abs(normals[triangles[faces]] @ np.array((0.36, 0.48, 0.80)))
        colour[meeting[faces]] = COLOURS[scene.states[triangles[faces]]] * shade[:, None]
        depth[meeting[faces]] = begun[meeting[faces]]
        left = meeting[~faces]
        if not len(left):
            break
    return colour, depth


def _is_seen(depth: np.ndarray, px: float, py: float, away_m: float) -> bool:
    row, column = int(py), int(px)
    inside = 0 <= row < depth.shape[0] and 0 <= column < depth.shape[1]
    return inside and bool(depth[row, column] > away_m - 0.15)


def _draw_mark(draw: ImageDraw.ImageDraw, x: float, y: float, colour: tuple[int, int, int]) -> None:
    draw.ellipse((x - 5, y - 5, x + 5, y + 5), fill=colour, outline=(255, 255, 255), width=1)
