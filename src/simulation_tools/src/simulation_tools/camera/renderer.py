"""A photograph: rays at each eighth pixel, plane cells filled, every pixel where edges or shadows pass."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from simulation_tools.camera import kernels
from simulation_tools.camera.defects import Decals
from simulation_tools.camera.effects import shading
from simulation_tools.camera.effects.amounts import Effects
from simulation_tools.camera.effects.layout import layout_of
from simulation_tools.camera.effects.lens import through_condensation
from simulation_tools.camera.metering import BASE_ISO, Metered, Seen, asked_m2, meter
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.surfaces import Surfaces
from simulation_tools.camera.textures import clouds, grain, levels
from simulation_tools.geometry import Pose

STEP = 8
METERED = 32
"""Points along each side of a picture by which the exposure is metered before it is taken."""
METERED_M = 0.01
"""What a point of the meter covers of a surface."""
WHITE = 16384.0
"""Linear value of white. Two stops above it are kept until the picture is developed."""


class Photograph(NamedTuple):
    """picture: uint8 (height, width, 3), sRGB. lux: in the picture's middle. iso: chosen by the meter."""

    picture: np.ndarray
    lux: float
    iso: float


class Lighting(NamedTuple):
    """What a photograph will be like. lux: in the picture's middle. metered: its exposure."""

    lux: float
    metered: Metered


class _Points(NamedTuple):
    """faces (n,), lit (n,), lights (n, 4) of `kernels.light`; points_m (n, 3) in the world."""

    faces: np.ndarray
    lit: np.ndarray
    lights: np.ndarray
    points_m: np.ndarray


class Renderer:
    """Photographs surfaces with their marks by the light of the camera's own lamp.

    effects: None or none of them: the picture is the same, bit for bit.
    """

    def __init__(
        self,
        surfaces: Surfaces,
        decals: Decals,
        optics: CameraOptics | None = None,
        effects: Effects | None = None,
    ) -> None:
        self.optics = optics or CameraOptics()
        self.effects = effects or Effects()
        self._layout: Any = tuple(layout_of(self.effects, surfaces)) if self.effects.is_any else None
        self._surfaces = surfaces
        self._axes = np.stack((surfaces.normals, surfaces.u_axes, surfaces.v_axes), axis=1)
        self._marks = tuple(decals)
        self._tiles = levels(clouds(1, 0.4), 6)
        self._clouds = clouds(2, 1.3)

    def photograph(
        self, optical_pose: Pose, rng: np.random.Generator, detail_m: float = 0.0, bias_ev: float = 0.0
    ) -> Photograph:
        """Return what the camera sees. optical_pose: of the optical frame in the world. rng: of the noise.

        detail_m: what a pixel covers at most of what the photograph is to show; 0: the whole picture counts.
        bias_ev: exposure compensation.
        """
        optics = self.optics
        columns, rows = -(-optics.width // STEP) + 1, -(-optics.height // STEP) + 1
        x, y = np.meshgrid(np.arange(columns) * STEP, np.arange(rows) * STEP)
        grid = self._look(optical_pose, np.column_stack((x.ravel(), y.ravel())))
        faces, lit = grid.faces.reshape(rows, columns), grid.lit.reshape(rows, columns)
        lights = grid.lights.reshape(rows, columns, 4)
        mixed = np.empty((rows - 1, columns - 1), np.bool_)
        kernels.mixed_cells(faces, lit, mixed)
        ambient = optics.ambient * float(lights[..., 2].mean())
        metered = self.meter(optical_pose, detail_m, bias_ev).metered
        gain = metered.gain * WHITE
        look: Any = (self._surfaces.albedos, self._marks, self._tiles, self._clouds, gain, ambient)
        raw = np.zeros((optics.height, optics.width, 3), np.uint16)
        kernels.fill_grid(raw, faces, mixed, lights, STEP, *look)
        lamp = optical_pose.transform(np.array(optics.lamp_offset_m))
        over: Any = (self._layout, lamp, np.array(optical_pose.position_m), gain, ambient)
        if self._layout is not None:
            shading.overlay_grid(raw, faces, mixed, lights, STEP, *over)
        at = np.argwhere(mixed)
        if len(at):
            places = np.ascontiguousarray(at[:, ::-1] * STEP)
            patches = self._refined(optical_pose, places)
            kernels.fill_patches(raw, places, *patches, *look)
            if self._layout is not None:
                shading.overlay_patches(raw, places, *patches, *over)
        if self.effects.condensation > 0.0:
            through_condensation(raw, self.effects.condensation, self.effects.seed)
        lux = float(lights[rows // 2, columns // 2, 2]) + ambient
        picture = self._developed(raw, metered.iso, rng)
        return Photograph(picture, lux, metered.iso)

    def meter(self, optical_pose: Pose, detail_m: float = 0.0, bias_ev: float = 0.0) -> Lighting:
        """Return light and exposure of a photograph before it is taken."""
        optics = self.optics
        across, down = optics.width / METERED, optics.height / METERED
        x, y = np.meshgrid((np.arange(METERED) + 0.5) * across, (np.arange(METERED) + 0.5) * down)
        grid = self._look(optical_pose, np.column_stack((x.ravel(), y.ravel())))
        middle = self._look(optical_pose, np.array([optics.centre_px]))
        ambient = optics.ambient * float(grid.lights[:, 2].mean())
        metered = self._metered(optical_pose, grid, ambient, detail_m, bias_ev)
        return Lighting(float(middle.lights[0, 2]) + ambient, metered)

    def depths_m(self, optical_pose: Pose, pixels: np.ndarray) -> np.ndarray:
        """Return (n,) how far ahead along the optical axis the surface at pixels (n, 2) is; inf: none."""
        optics = self.optics
        aside = (pixels - np.array(optics.centre_px)) / optics.focal_px
        rays = np.column_stack((aside, np.ones(len(aside))))
        lengths = np.linalg.norm(rays, axis=1)
        origins = np.broadcast_to(np.array(optical_pose.position_m), rays.shape)
        _, distances = self._surfaces.nearest(origins, rays @ optical_pose.rotation.T / lengths[:, None])
        return distances / lengths

    def _look(self, pose: Pose, pixels: np.ndarray) -> _Points:
        """Return what lies behind pixels (n, 2), and how the lamp lights it."""
        optics, centre = self.optics, np.array(self.optics.centre_px)
        turn, eye = pose.rotation, np.array(pose.position_m)
        aside = (pixels - centre) / optics.focal_px
        directions = np.column_stack((aside, np.ones(len(aside)))) @ turn.T
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        origins = np.broadcast_to(eye, directions.shape)
        faces, distances = self._surfaces.nearest(origins, directions)
        points = self._on_plane(faces, eye, directions, distances)
        lamp = pose.transform(np.array(optics.lamp_offset_m))
        lit = self._lit(faces, points, lamp)
        lights = np.empty((len(faces), 4))
        args = (lamp, turn[:, 2].copy(), centre, optics.vignetting, optics.lamp_cd)
        kernels.light(
            pixels.astype(np.float64), faces, lit, points, self._axes, self._surfaces.offsets_m, *args, lights
        )
        return _Points(faces, lit, lights, points)

    def _on_plane(
        self, faces: np.ndarray, eye: np.ndarray, directions: np.ndarray, distances: np.ndarray
    ) -> np.ndarray:
        """Return the points (n, 3) of rays in double precision, which Embree does not have."""
        normals = self._surfaces.normals[faces]
        slope = np.einsum("ij,ij->i", normals, directions)
        exact = (self._surfaces.offsets_m[faces] - normals @ eye) / np.where(slope == 0.0, 1.0, slope)
        near = np.abs(exact - distances) < 0.01
        far = np.where(near, exact, np.where(np.isfinite(distances), distances, 0.0))
        return eye + far[:, None] * directions

    def _lit(self, faces: np.ndarray, points: np.ndarray, lamp: np.ndarray) -> np.ndarray:
        """Return whether the lamp's light reaches points (n, 3)."""
        ways = points - lamp
        lengths = np.maximum(np.linalg.norm(ways, axis=1), 1e-6)
        _, distances = self._surfaces.nearest(np.broadcast_to(lamp, ways.shape), ways / lengths[:, None])
        return (faces >= 0) & (distances > lengths - 2e-3)

    def _refined(self, pose: Pose, places: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return faces, lit (n, 9, 9) and lights (n, 9, 9, 4) of mixed cells, where they are needed."""
        n = len(places)
        faces, lit = np.full((n, 9, 9), -1, np.int32), np.zeros((n, 9, 9), np.bool_)
        lights, known = np.zeros((n, 9, 9, 4)), np.zeros((n, 9, 9), np.bool_)
        ask = np.zeros((n, 9, 9), np.bool_)
        ask[:, ::STEP, ::STEP] = True
        for size in (8, 4, 2, 1):
            if size < STEP:
                ask[:] = False
                kernels.wanted(faces, lit, known, size, ask)
            k, b, a = np.nonzero(ask)
            if len(k):
                seen = self._look(pose, places[k] + np.column_stack((a, b)))
                faces[k, b, a], lit[k, b, a], lights[k, b, a] = seen[:3]
                known[k, b, a] = True
        return faces, lit, lights

    def _metered(self, pose: Pose, grid: _Points, ambient: float, detail_m: float, bias_ev: float) -> Metered:
        """Return the exposure for what is seen at the points of a grid."""
        seen = grid.faces >= 0
        faces, lights = grid.faces[seen], grid.lights[seen]
        light = (lights[:, 2] + ambient) * lights[:, 3]
        albedos = self._surfaces.albedos[faces]
        if self._layout is not None:
            left = np.empty(albedos.shape)
            shading.tints(faces, lights, METERED_M, self._layout, left)
            albedos = albedos * left
        rays = grid.points_m[seen] - np.array(pose.position_m)
        lengths_m = np.maximum(np.linalg.norm(rays, axis=1), 1e-6)
        depths_m = np.maximum(rays @ pose.rotation[:, 2], 1e-6)
        facing = np.abs(np.einsum("ij,ij->i", self._surfaces.normals[faces], rays)) / lengths_m
        areas_m2 = asked_m2(depths_m, lengths_m / depths_m, facing, self.optics.focal_px, detail_m)
        points = Seen(
            light * (albedos @ (0.2126, 0.7152, 0.0722)), light * albedos.min(axis=1),
            light * albedos.max(axis=1), areas_m2,
        )  # fmt: skip
        exposure_s, f_number = self.optics.exposure_s, self.optics.f_number
        return meter(points, exposure_s, f_number, bias_ev, protects=detail_m > 0.0)

    def _developed(self, raw: np.ndarray, iso: float, rng: np.random.Generator) -> np.ndarray:
        electrons = self.optics.full_well_e * BASE_ISO / iso  # of white
        share = (np.arange(4096) * 16.0 + 8.0) / WHITE
        sigma = WHITE * np.sqrt(share * electrons + self.optics.read_noise_e**2) / electrons
        light = np.clip(share, 0.0, 1.0)
        curve = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        gamma = np.round(255.0 * curve).astype(np.uint8)
        picture = np.empty(raw.shape, np.uint8)
        starts = rng.integers(0, 1 << 20, raw.shape[0])
        kernels.develop(raw, grain(3), starts, sigma.astype(np.float32), gamma, picture)
        return picture
