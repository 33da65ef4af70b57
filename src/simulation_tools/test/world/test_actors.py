"""Actors in the world: where they are at which time, what sees them, what they touch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Script, Trajectory, Waypoint
from simulation_tools.sdf.parser import parse_model
from simulation_tools.world.scripted_motion import ScriptedMotion
from simulation_tools.world.world import BodyState

from .conftest import box, shape, solid_box

STEP_S = 0.004


def trajectory(*corners, tension=0.0, yaw=0.0):
    """Corners are (time, x, y); yaw is turned by from each one to the next."""
    return Trajectory(
        tuple(Waypoint(t, Pose.from_xyz_rpy(x, y, 1.0, yaw=k * yaw)) for k, (t, x, y) in enumerate(corners)),
        tension,
    )


def motion(*trajectories, **script):
    return ScriptedMotion(Script(trajectories, **script))


def place(scripted, time_s):
    return scripted.state(time_s).pose.position_m


def actor(script, size=(0.5, 0.5, 2.0), pose="0 0 0 0 0 0", name="walker"):
    text = f'<actor name="{name}"><pose>{pose}</pose><link name="l">{shape(box(*size))}</link>'
    return parse_model(f'<sdf version="1.6">{text}<script>{script}</script></actor></sdf>', "text", [])


def line(*corners):
    points = "".join(
        f"<waypoint><time>{t}</time><pose>{x} {y} 1 0 0 0</pose></waypoint>" for t, x, y in corners
    )
    return f'<trajectory id="0" type="line">{points}</trajectory>'


def run(world, seconds):
    for _ in range(round(seconds / STEP_S)):
        world.step()


# -- where it is ---------------------------------------------------------------------------------------------
@pytest.mark.table("time_s", [1.0, 1.3, 2.0, 2.75, 3.0])
def test_between_waypoints_at_even_distances_it_moves_evenly(time_s):
    walk = motion(trajectory((0, 0, 0), (1, 2, 1), (2, 4, 2), (3, 6, 3), (4, 8, 4)))
    state = walk.state(time_s)
    assert state.pose.position_m == pytest.approx((2 * time_s, time_s, 1.0))
    assert state.linear_velocity_m_s == pytest.approx((2.0, 1.0, 0.0))


def test_on_a_lone_piece_it_starts_and_ends_at_half_its_mean_speed():
    """Both tangents are half the way: x is the way times u/2 + 3/2 u^2 - u^3."""
    walk = motion(trajectory((0, 0, 0), (4, 8, 0)))
    for time_s in (0.0, 0.4, 1.0, 2.0, 3.9, 3.999999):
        u = time_s / 4
        assert place(walk, time_s)[0] == pytest.approx(8 * (0.5 * u + 1.5 * u**2 - u**3))
        speed = 2.0 * (0.5 + 3.0 * u - 3.0 * u**2)
        assert walk.state(time_s).linear_velocity_m_s == pytest.approx((speed, 0.0, 0.0))


def test_with_full_tension_it_halts_at_each_waypoint():
    walk = motion(trajectory((0, 0, 0), (1, 3, 0), (3, 3, 4), tension=1.0))
    assert walk.state(1.0).linear_velocity_m_s == (0.0, 0.0, 0.0)
    assert place(walk, 1.0) == (3.0, 0.0, 1.0)
    assert place(walk, 2.0) == (3.0, 2.0, 1.0)  # half of the way at half of the time
    assert place(walk, 1.5) == pytest.approx((3.0, 4 * (3 / 16 - 2 / 64), 1.0))  # 3 u^2 - 2 u^3 at a quarter


def test_a_closed_way_has_one_tangent_where_it_begins_and_ends():
    square = motion(trajectory((0, 0, 0), (1, 2, 0), (2, 2, 2), (3, 0, 2), (4, 0, 0)))
    assert square.state(0.0).linear_velocity_m_s == pytest.approx((1.0, -1.0, 0.0))
    assert square.state(4.0 - 1e-9).linear_velocity_m_s == pytest.approx((1.0, -1.0, 0.0), abs=1e-6)
    assert place(square, 4.0) == place(square, 0.0)


def test_it_turns_evenly_the_short_way():
    turn = motion(trajectory((0, 0, 0), (2, 1, 0), yaw=math.radians(170)))
    state = turn.state(0.5)
    assert state.pose.yaw_rad == pytest.approx(math.radians(42.5))
    assert state.angular_velocity_rad_s == pytest.approx((0.0, 0.0, math.radians(85)))


def test_a_script_waits_loops_and_ends_as_gazebos_does():
    there_and_back = trajectory((1, 0, 0), (2, 4, 0), tension=1.0), trajectory((1, 0, 0))
    loop = motion(*there_and_back, delay_s=0.5)
    assert loop.state(0.49) is None
    assert place(loop, 1.4) == (0.0, 0.0, 1.0)  # it waits for its first waypoint's time
    assert place(loop, 2.0) == pytest.approx((2.0, 0.0, 1.0))
    assert place(loop, 3.0) == (0.0, 0.0, 1.0)  # the second trajectory
    assert place(loop, 3.7) == (0.0, 0.0, 1.0)  # the delay before the second round
    assert place(loop, 2.0 + 3.5) == pytest.approx((2.0, 0.0, 1.0))
    assert place(loop, 2.0 + 35.0) == pytest.approx((2.0, 0.0, 1.0))
    once = motion(there_and_back[0], loop=False)
    assert once.state(99.0) == BodyState(there_and_back[0].waypoints[-1].pose)
    assert motion(*there_and_back, starts=False).state(9.0) is None


# -- in the world --------------------------------------------------------------------------------------------
def test_it_goes_with_the_worlds_time_and_begins_anew_with_it(build):
    world = build(actor(line((0, 0, 0), (1, 2, 0), (2, 4, 0), (3, 6, 0)), pose="9 9 9 0 0 0"))
    assert world.get_state("walker").pose.position_m == (0.0, 0.0, 1.0)
    run(world, 1.6)
    state = world.get_state("walker")
    assert state.pose.position_m == pytest.approx((3.2, 0.0, 1.0))
    assert state.linear_velocity_m_s == pytest.approx((2.0, 0.0, 0.0))
    assert world.link_state("walker", "l") == state
    world.reset()
    assert world.get_state("walker").pose.position_m == (0.0, 0.0, 1.0)
    run(world, 1.2)
    assert world.get_state("walker").pose.position_m == pytest.approx((2.4, 0.0, 1.0))


def test_a_later_actor_begins_then_and_one_that_does_not_start_stays(build):
    world = build()
    run(world, 1.0)
    walk = line((0, 0, 0), (1, 2, 0), (2, 4, 0), (3, 6, 0))
    world.spawn(actor(walk), "late", Pose())
    world.spawn(actor(walk + "<auto_start>false</auto_start>"), "idle", Pose.from_xyz_rpy(0, 7, 1))
    run(world, 1.2)
    assert world.get_state("late").pose.position_m == pytest.approx((2.4, 0.0, 1.0))
    assert world.get_state("idle").pose.position_m == (0.0, 7.0, 1.0)


def test_rays_and_distances_follow_it(build):
    world = build(actor(line((0, 0, 0), (1, 2, 0), (2, 4, 0), (3, 6, 0))))
    world.spawn(solid_box(0.2, 0.2, 0.2, 1.0), "probe", Pose.from_xyz_rpy(3.0, 5.0, 1.0))
    ahead = np.array(((1.0, 0.0, 0.0),))
    for time_s in (1.0, 1.5, 2.0):
        run(world, 0.5 if time_s > 1.0 else 1.0)
        x = 2.0 * time_s
        assert world.rays.cast(np.array((-1.0, 0.0, 1.0)), ahead, 50.0)[0] == pytest.approx(
            x + 0.75, abs=1e-5
        )
        beside = Pose.from_xyz_rpy(x, 0.65, 1.0)
        assert world.clearance("probe", beside, 5.0) == pytest.approx(0.3, abs=1e-3)


def test_what_it_runs_into_is_touched_and_pushed_but_does_not_hold_it_up(build):
    world = build(actor(line((0, 0, 0), (1, 1, 0), (2, 2, 0), (3, 3, 0))), gravity=(0.0, 0.0, 0.0))
    world.spawn(solid_box(0.4, 0.4, 0.4, 1.0), "ball", Pose.from_xyz_rpy(1.95, 0.0, 1.0))
    run(world, 1.4)
    assert not world.contacts("ball")
    touched = []
    for _ in range(100):
        world.step()
        touched += world.contacts("ball")
    assert {contact.collision_2 for contact in touched} == {"walker::l::c"}
    assert world.get_state("ball").pose.position_m[0] > 2.0
    assert world.get_state("walker").pose.position_m == pytest.approx((1.8, 0.0, 1.0))
