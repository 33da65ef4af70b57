"""Which of a part's shapes a point belongs to."""

from __future__ import annotations

import numpy as np
import pytest

from simulation_tools.geometry import IDENTITY, Pose
from simulation_tools.sdf.elements import Box, Collision, Cylinder, Plane, Sphere
from simulation_tools.world.assembly import PlacedCollision
from simulation_tools.world.contacts import distance_to, nearest

GEOMETRIES = (
    Box((0.5, 0.4, 0.1)),
    Cylinder(0.1, 0.6),
    Sphere(0.2),
    Plane((0.0, 0.0, 1.0)),
    Box((2.0, 0.1, 0.1)),
)


@pytest.mark.table("seed", range(5))
def test_a_point_belongs_to_the_shape_whose_surface_is_nearest(seed):
    rng = np.random.default_rng(seed)
    shapes = [
        PlacedCollision(
            "l", Collision(str(k), IDENTITY, geometry), Pose.from_xyz_rpy(*rng.uniform(-1.0, 1.0, 6))
        )
        for k, geometry in enumerate(GEOMETRIES)
    ]
    for point in rng.uniform(-1.5, 1.5, (100, 3)):
        distances = [abs(distance_to(shape, tuple(point))) for shape in shapes]
        assert nearest(shapes, tuple(point)) is shapes[int(np.argmin(distances))]
