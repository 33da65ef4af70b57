"""Motion against closed forms: falling, pushing, turning, swinging, resting, sliding."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy

from simulation_tools.geometry import Pose, rotate
from simulation_tools.sdf.frames import attach
from simulation_tools.sdf.parser import load_model
from simulation_tools.world.engine import pybullet
from simulation_tools.world.world import BodyState

from .conftest import mass, model, solid_box

DT = 0.004
G = 9.8


def run(world, name, steps, wrench=None):
    for _ in range(steps):
        if wrench is not None:
            world.apply_wrench(name, *wrench)
        world.step()
    return world.get_state(name)


def test_free_fall_is_that_of_the_closed_form(build):
    world = build()
    world.spawn(solid_box(1, 1, 1, 3), "b", Pose.from_xyz_rpy(0, 0, 100))
    start = BodyState(Pose.from_xyz_rpy(0, 0, 100), (2.0, 0.0, 5.0), (0.0, 0.0, 0.0))
    world.set_state("b", start)
    n = 500
    state = run(world, "b", n)
    t = n * DT
    # Semi-implicit Euler: z_n = z_0 + v t - g dt^2 n (n + 1) / 2, half a step's fall below the parabola.
    assert state.pose.position_m[2] == pytest.approx(100 + 5 * t - G * DT**2 * n * (n + 1) / 2, abs=1e-9)
    assert state.pose.position_m[2] == pytest.approx(
        100 + 5 * t - 0.5 * G * t**2, abs=0.5 * G * DT * t + 1e-9
    )
    assert state.pose.position_m[0] == pytest.approx(2 * t, abs=1e-9)
    assert state.linear_velocity_m_s[2] == pytest.approx(5 - G * t, abs=1e-9)


def test_links_without_gravity_have_no_weight(build):
    def pair(light, heavy):
        return model(
            f'<link name="a">{mass(1, 0.1, 0.1, 0.1)}<gravity>{light}</gravity></link>'
            f'<link name="b"><pose>0 0 1 0 0 0</pose>{mass(3, 1, 1, 1)}<gravity>{heavy}</gravity></link>'
            '<joint name="j" type="fixed"><parent>a</parent><child>b</child></joint>'
        )

    world = build(
        pair(1, 1).placed("both"), pair(1, 0).placed("one"), pair(0, 0).placed("none"), gravity=(0, 0, -1.6)
    )
    for _ in range(10):
        world.step()
    # Of 4 kg one or none weighs something.
    for name, share in (("both", 1.0), ("one", 0.25), ("none", 0.0)):
        state = world.get_state(name)
        np.testing.assert_allclose(state.linear_velocity_m_s, (0, 0, -share * 1.6 * 10 * DT), atol=1e-9)
    world.delete("none")
    world.step()


def test_nothing_slows_down_by_itself(build):
    world = build(gravity=(0.0, 0.0, 0.0))
    world.spawn(solid_box(1, 1, 1, 3), "b", Pose())
    world.set_state("b", BodyState(Pose(), (1.0, 2.0, 3.0), (0.0, 0.0, 2.0)))
    state = run(world, "b", 2000)
    np.testing.assert_allclose(state.linear_velocity_m_s, (1, 2, 3), atol=1e-9)
    np.testing.assert_allclose(state.angular_velocity_rad_s, (0, 0, 2), atol=1e-9)
    assert state.pose.yaw_rad == pytest.approx(math.remainder(2.0 * 2000 * DT, 2 * math.pi), abs=1e-6)


def test_a_wrench_acts_in_body_axes_for_one_step_only(build):
    world = build(gravity=(0.0, 0.0, 0.0))
    pose = Pose.from_xyz_rpy(1, 2, 3, 0.4, -0.5, 2.0)
    world.spawn(solid_box(1, 2, 3, 2), "b", pose)
    inertia = 2 * (4 + 9) / 12
    state = run(world, "b", 1, ((4.0, 0.0, 0.0), (5.0, 0.0, 0.0)))
    np.testing.assert_allclose(
        state.linear_velocity_m_s, rotate(pose.orientation_xyzw, (4 * DT / 2, 0, 0)), atol=1e-12
    )
    np.testing.assert_allclose(
        state.angular_velocity_rad_s, rotate(pose.orientation_xyzw, (5 * DT / inertia, 0, 0)), atol=1e-12
    )
    later = run(world, "b", 1)
    np.testing.assert_allclose(later.linear_velocity_m_s, state.linear_velocity_m_s, atol=1e-12)


def test_a_force_acts_at_the_centre_of_mass_wherever_the_model_frame_is(build):
    world = build(gravity=(0.0, 0.0, 0.0))
    # Given a body whose centre of mass is off its frame, with principal axes turned by 30 degrees
    body = model(f'<link name="l">{mass(2, 0.1, 0.2, 0.25, "0.3 -0.1 0.2 0 0 0.5236")}</link>')
    world.spawn(body, "b", Pose.from_xyz_rpy(0, 0, 0, 0, 0, 1.0))
    np.testing.assert_allclose(world.centre_of_mass("b"), (0.3, -0.1, 0.2))
    # When it is pushed, then it does not turn
    state = run(world, "b", 10, ((0.0, 6.0, 0.0), (0.0, 0.0, 0.0)))
    np.testing.assert_allclose(state.angular_velocity_rad_s, 0.0, atol=1e-12)
    expected = rotate(Pose.from_xyz_rpy(0, 0, 0, 0, 0, 1.0).orientation_xyzw, (0, 6.0 / 2.0 * 10 * DT, 0))
    np.testing.assert_allclose(state.linear_velocity_m_s, expected, atol=1e-12)
    # And a torque about z turns it about its centre of mass, so that its origin moves
    world.set_state("b", BodyState(Pose()))
    state = run(world, "b", 1, ((0.0, 0.0, 0.0), (0.0, 0.0, 5.0)))
    spin = 5.0 / 0.25 * DT
    np.testing.assert_allclose(state.angular_velocity_rad_s, (0, 0, spin), atol=1e-9)
    np.testing.assert_allclose(state.linear_velocity_m_s, (spin * -0.1, spin * -0.3, 0), atol=1e-3 * spin)


def test_the_products_of_inertia_are_heeded(build):
    world = build(gravity=(0.0, 0.0, 0.0))
    tensor = np.array(((0.3, 0.05, -0.02), (0.05, 0.25, 0.04), (-0.02, 0.04, 0.4)))
    xml = (
        "<inertial><mass>1</mass><inertia><ixx>.3</ixx><iyy>.25</iyy><izz>.4</izz>"
        "<ixy>.05</ixy><ixz>-.02</ixz><iyz>.04</iyz></inertia></inertial>"
    )
    world.spawn(model(f'<link name="l">{xml}</link>'), "b", Pose())
    torque = np.array((1.0, -2.0, 0.5))
    state = run(world, "b", 1, ((0.0, 0.0, 0.0), tuple(torque)))
    np.testing.assert_allclose(state.angular_velocity_rad_s, np.linalg.solve(tensor, torque) * DT, atol=1e-9)
    np.testing.assert_allclose(world.inertia("b"), tensor)


def test_a_tumbling_body_follows_eulers_equations(build):
    world = build(gravity=(0.0, 0.0, 0.0), time_step_s=0.0005)
    inertia = np.array((0.1, 0.2, 0.25))
    world.spawn(model(f'<link name="l">{mass(1, *inertia)}</link>'), "b", Pose())
    start = np.array((1.0, 0.3, 2.0))
    world.set_state("b", BodyState(Pose(), (0.0, 0.0, 0.0), tuple(start)))
    end = 2.0
    reference = scipy.integrate.solve_ivp(
        lambda _, w: -np.cross(w, inertia * w) / inertia, (0, end), start, rtol=1e-10, atol=1e-12
    ).y[:, -1]
    state = run(world, "b", round(end / 0.0005))
    body_rates = rotate(state.pose.inverse().orientation_xyzw, state.angular_velocity_rad_s)
    np.testing.assert_allclose(body_rates, reference, atol=0.01)


def test_a_pendulum_on_a_revolute_joint_swings_with_its_period(build):
    # A rod of 1 m, hung at its end from the world: T = 2 pi sqrt(2 L / (3 g)) for small swings.
    rod = model(
        f'<link name="rod">{mass(1, 1 / 12, 1 / 12, 1e-4)}</link><joint name="pivot" type="revolute">'
        "<pose>0 0 .5 0 0 0</pose><parent>world</parent><child>rod</child>"
        "<axis><xyz>0 1 0</xyz></axis></joint>"
    )
    world = build(time_step_s=0.001)
    world.spawn(rod, "p", Pose.from_xyz_rpy(0, 0, 2))
    body = world._there.models["p"].bodies[0][0].uid
    pybullet.resetJointState(body, 0, 0.05, physicsClientId=world._client)
    angles = []
    for _ in range(4000):
        world.step()
        angles.append(pybullet.getJointState(body, 0, physicsClientId=world._client)[0])
    angles = np.array(angles)
    crossings = np.flatnonzero((angles[:-1] > 0) & (angles[1:] <= 0))
    period = np.mean(np.diff(crossings)) * 0.001
    assert period == pytest.approx(2 * math.pi * math.sqrt(2 / (3 * G)), rel=2e-3)
    assert abs(angles).max() == pytest.approx(0.05, rel=0.02)


def test_rigid_joints_are_lumped_and_weigh_as_much(build):
    hinged = model(
        f'<link name="a">{mass(1, 0.1, 0.1, 0.1)}</link>'
        f'<link name="b"><pose>1 0 0 0 0 0</pose>{mass(3, 0.1, 0.1, 0.1)}</link>'
        '<joint name="j" type="revolute"><parent>a</parent><child>b</child>'
        "<axis><xyz>0 0 1</xyz></axis></joint>"
    )
    world = build(gravity=(0.0, 0.0, 0.0))
    world.spawn(hinged, "b", Pose(), frozenset({"j"}))
    assert world.mass_kg("b") == 4.0
    np.testing.assert_allclose(world.centre_of_mass("b"), (0.75, 0, 0))
    # 2 x 0.1 + m1 m2 / (m1 + m2) d^2 = 0.95 about z
    state = run(world, "b", 1, ((0, 0, 0), (0, 0, 1.9)))
    assert state.angular_velocity_rad_s[2] == pytest.approx(2.0 * DT, rel=1e-9)


def test_a_box_rests_on_the_plane(build):
    world = build(ground=True)
    world.spawn(solid_box(0.4, 0.4, 0.2, 1.5), "b", Pose.from_xyz_rpy(0, 0, 0.11))
    run(world, "b", 500)
    heights = [run(world, "b", 1).pose.position_m[2] for _ in range(250)]
    assert heights[-1] == pytest.approx(0.1, abs=1e-3)
    assert np.ptp(heights) < 1e-5
    assert sum(contact.force_n for contact in world.contacts("b")) == pytest.approx(1.5 * G, rel=1e-2)


@pytest.mark.parametrize("friction", [0.2, 0.6])
def test_a_sliding_box_stops_after_v2_over_2_mu_g(build, friction):
    surface = f"<surface><friction><ode><mu>{friction}</mu></ode></friction></surface>"
    world = build(ground=True)
    world.spawn(solid_box(0.4, 0.4, 0.1, 1, more=surface), "b", Pose.from_xyz_rpy(0, 0, 0.05))
    run(world, "b", 100)
    here = world.get_state("b").pose
    world.set_state("b", BodyState(here, (2.0, 0.0, 0.0)))
    gone = run(world, "b", 1000).pose.position_m[0] - here.position_m[0]
    assert gone == pytest.approx(2.0**2 / (2 * friction * G), rel=0.05)


ROTORS = frozenset(f"rotor_{number}_joint" for number in range(4))


@pytest.mark.parametrize("lidar", [None, "ust", "m8"])
def test_the_iris_stands_still_on_its_feet(build, lidar):
    iris = load_model("model://iris")
    if lidar:
        iris = attach(iris, load_model(f"model://lidar_{lidar}"), "lidar_mount")
    world = build(ground=True)
    world.spawn(iris, "iris", Pose.from_xyz_rpy(0, 0, 0.12), ROTORS)
    places = np.array([run(world, "iris", 1).pose.position_m for _ in range(1500)])
    assert np.ptp(places, axis=0).max() < 2e-4
    assert places[-1, 2] == pytest.approx(0.12, abs=1e-3)
    assert len({contact.collision_1 for contact in world.contacts("iris")}) == 4


@pytest.mark.parametrize(("sink_m_s", "roll"), [(0.75, 0.0), (0.75, 0.1), (1.5, 0.05)])
def test_a_landing_ends_upright_without_bouncing_off(build, sink_m_s, roll):
    world = build(ground=True)
    world.spawn(load_model("model://iris"), "iris", Pose(), ROTORS)
    world.set_state("iris", BodyState(Pose.from_xyz_rpy(0, 0, 0.2, roll, 0, 0), (0.0, 0.0, -sink_m_s)))
    touched, heights = False, []
    for _ in range(750):
        state = run(world, "iris", 1)
        touched = touched or bool(world.contacts("iris"))
        if touched:
            heights.append(state.pose.position_m[2])
    assert touched
    assert max(heights[60:]) < 0.125  # a quarter of a second after touch-down it stands
    assert heights[-1] == pytest.approx(0.12, abs=1e-3)
    assert max(map(abs, state.pose.rpy_rad[:2])) < 0.01


@pytest.mark.parametrize(("friction", "holds"), [(5.2, True), (4.5, False)])
def test_dry_friction_holds_a_hinge_up_to_its_torque(build, friction, holds):
    # A rod of 1 kg and 1 m, level, on a hinge at its end: its weight's torque is m g L / 2 = 4.9 N m.
    rod = model(
        f'<link name="rod">{mass(1, 1e-4, 1 / 12, 1 / 12)}</link><joint name="pivot" type="revolute">'
        "<pose>-.5 0 0 0 0 0</pose><parent>world</parent><child>rod</child><axis><xyz>0 1 0</xyz>"
        f"<dynamics><friction>{friction}</friction></dynamics></axis></joint>"
    )
    world = build()
    world.spawn(rod, "p", Pose.from_xyz_rpy(0, 0, 2))
    for _ in range(250):
        world.step()
    angle = world.joint_angles()["p::pivot"]
    if holds:
        assert abs(angle) < 1e-3
    else:
        # About the hinge J = m L^2 / 3: for a small angle, alpha = (4.9 - friction) / J for a second.
        assert angle == pytest.approx(0.5 * (G / 2 - friction) * 3, rel=0.15)
