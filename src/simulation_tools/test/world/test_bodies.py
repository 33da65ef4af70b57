"""What is drawn: every visual in its place and colour, as PyBullet's software renderer sees it."""

from __future__ import annotations

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import World
from simulation_tools.world.assembly import assemblies
from simulation_tools.world.bodies import BodyFactory
from simulation_tools.world.engine import pybullet
from simulation_tools.world.world import PhysicsWorld, WorldError

from .conftest import model


@pytest.fixture
def client():
    number = pybullet.connect(pybullet.DIRECT)
    yield number
    pybullet.disconnect(number)


def picture(client, size=60):
    """Look down on a square of 6 x 6 m: rows from y = +3 to -3, columns from x = -3 to +3."""
    pixels = pybullet.getCameraImage(
        size,
        size,
        pybullet.computeViewMatrix((0, 0, 50), (0, 0, 0), (0, 1, 0)),
        pybullet.computeProjectionMatrixFOV(2 * np.degrees(np.arctan(3 / 50)), 1.0, 1.0, 100.0),
        renderer=pybullet.ER_TINY_RENDERER,
        shadow=0,
        physicsClientId=client,
    )[2]
    return np.reshape(pixels, (size, size, 4))[:, :, :3].astype(int)


@pytest.mark.parametrize("static", ["true", "false"])
def test_every_visual_is_drawn_in_its_place_and_colour(client, static):
    def visual(name, x, colour):
        return (
            f'<visual name="{name}"><pose>{x} 0 0 0 0 0</pose>'
            "<geometry><box><size>1 1 1</size></box></geometry>"
            f"<material><diffuse>{colour} 1</diffuse></material></visual>"
        )

    painted = model(
        f'<static>{static}</static><link name="l">{visual("red", 0, "1 0 0")}{visual("blue", 2, "0 0 1")}'
        f"{visual('too', -2, '1 0 0')}</link>"
    )
    factory = BodyFactory(client, draw=True)
    factory.create("painted", assemblies(painted), Pose.from_xyz_rpy(0, 1, 0))
    image = picture(client)
    factory.shapes.close()
    row = image[20]  # y = 1
    for x, strong, weak in ((0.0, 0, 2), (2.0, 2, 0), (-2.0, 0, 2)):
        pixel = row[int((x + 3) * 10)]
        assert pixel[strong] > 3 * max(pixel[weak], 1)
    assert (image[50] == 255).all()  # y = -2: nothing


@pytest.mark.table("display", ["", ":98765"])
def test_a_window_without_a_display_is_one_sentence(display, monkeypatch):
    monkeypatch.setenv("DISPLAY", display)
    with pytest.raises(WorldError, match="no display"):
        PhysicsWorld(World("w", ()), gui=True)
