"""Pictures of a PyBullet world, by its software renderer."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from simulation_tools.geometry import Vector3
from simulation_tools.world.engine import pybullet

LIGHT_DIRECTION = (0.3, 0.2, 1.0)
"""Towards the light."""

AMBIENT = 0.55


def draw(
    client: int,
    eye_m: Vector3,
    ahead: Vector3,
    up: Vector3,
    projection: Sequence[float],
    size: tuple[int, int],
) -> tuple[np.ndarray, np.ndarray]:
    """Return colours, uint8 (height, width, 3), and OpenGL's depth buffer, float32 (height, width).

    ahead, up: unit vectors in the world. projection: OpenGL's matrix, column by column. size: width, height.
    """
    width, height = size
    target = [place + step for place, step in zip(eye_m, ahead)]
    _, _, colours, depth, _ = pybullet.getCameraImage(
        width,
        height,
        pybullet.computeViewMatrix(eye_m, target, up),
        projection,
        lightDirection=LIGHT_DIRECTION,
        lightAmbientCoeff=AMBIENT,
        lightDiffuseCoeff=1.0 - AMBIENT,
        lightSpecularCoeff=0.0,  # every facet of a trunk would shine on its own
        shadow=0,
        renderer=pybullet.ER_TINY_RENDERER,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
        physicsClientId=client,
    )
    pixels = np.reshape(np.asarray(colours, np.uint8), (height, width, 4))
    return pixels[:, :, :3], np.reshape(np.asarray(depth, np.float32), (height, width))
