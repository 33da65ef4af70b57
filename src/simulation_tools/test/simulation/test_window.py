"""The window shows what is in the world, and leaves most of the time to the flight."""

import pytest

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import World
from simulation_tools.sdf.parser import parse_model
from simulation_tools.simulation.window import LONGEST_S, Window
from simulation_tools.world.kinematics import BodyState
from simulation_tools.world.world import PhysicsWorld

SHAPE = "<geometry><box><size>1 1 1</size></box></geometry>"
CUBE = (
    '<sdf version="1.6"><model name="cube"><link name="link">'
    f'<collision name="c">{SHAPE}</collision></link></model></sdf>'
)


class Clock:
    """Each call takes so long, s."""

    def __init__(self, step_s):
        self.now_s, self.step_s = 0.0, step_s

    def __call__(self):
        self.now_s += self.step_s
        return self.now_s


@pytest.fixture
def world():
    world = PhysicsWorld(World("shown", ()))
    world.spawn(parse_model(CUBE, "cube"), "cube", Pose((1.0, 2.0, 3.0)))
    yield world
    world.close()


def window_on(world, clock):
    return Window(world, "cube", has_window=False, clock=clock)


def test_it_shows_what_appears_moves_and_vanishes(world):
    window = window_on(world, Clock(LONGEST_S))
    assert window.copy.get_state("cube").pose.position_m == pytest.approx((1.0, 2.0, 3.0))
    world.set_state("cube", BodyState(Pose((4.0, 5.0, 6.0))))
    world.spawn(parse_model(CUBE, "cube"), "another", Pose((9.0, 0.0, 0.0)))
    assert window.update()
    assert window.copy.get_state("cube").pose.position_m == pytest.approx((4.0, 5.0, 6.0))
    assert window.copy.get_state("another").pose.position_m == pytest.approx((9.0, 0.0, 0.0))
    world.delete("another")
    assert window.update()
    assert window.copy.model_names() == ["cube"]
    window.close()
