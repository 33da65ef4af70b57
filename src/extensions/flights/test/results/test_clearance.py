"""Distances along a path, in worlds whose distances are known by hand."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from flights.results.clearance import distances_in
from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import World
from simulation_tools.sdf.parser import parse_model
from simulation_tools.world.world import PhysicsWorld

BALL = (
    '<sdf version="1.6"><model name="ball"><link name="l"><collision name="c"><geometry><sphere>'
    "<radius>0.2</radius></sphere></geometry></collision></link></model></sdf>"
)
POSES = np.array([(0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0), (1.0, 3.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0)])
"""At 2 m height: in the middle of a room of 8 m, and 1 m from its wall."""


def least_m(geometry, folder, pose="0 0 0 0 0 0"):
    """Return the distances of a ball of 0.2 m from a static model `floor` that carried it."""
    text = (
        f'<sdf version="1.6"><model name="floor"><static>1</static><pose>{pose}</pose><link name="l">'
        f'<collision name="c"><geometry>{geometry}</geometry></collision></link></model></sdf>'
    )
    world = PhysicsWorld(World("w", (parse_model(text, "t", [folder]),)))
    try:
        world.spawn(parse_model(BALL, "t", []), "ball", Pose.from_xyz_rpy(0, 0, 1))
        return distances_in(world, "ball", POSES, 0.0, ["floor", "a model that is gone"])[:, 1].tolist()
    finally:
        world.close()


def test_a_floor_does_not_count(tmp_path):
    nothing = [np.inf, np.inf]
    assert least_m("<plane/>", tmp_path) == nothing
    assert least_m("<box><size>20 20 0.2</size></box>", tmp_path) == nothing


def test_a_world_that_is_one_mesh_has_walls(tmp_path):
    """A room of 8 x 8 x 6 m, open to the inside: the floor is 2 m below, the wall 4 m and 1 m away."""
    room = trimesh.creation.box((8, 8, 6)).apply_translation((0, 0, 3))
    room.export(tmp_path / "room.stl")
    found_m = least_m(f"<mesh><uri>file://{tmp_path}/room.stl</uri></mesh>", tmp_path)
    assert found_m == pytest.approx([2.0 - 0.2, 1.0 - 0.2], abs=0.01)
