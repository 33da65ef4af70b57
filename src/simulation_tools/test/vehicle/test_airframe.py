"""Rotor forces against closed form, a slow reference in numpy, and bad SDF."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Inertial, Joint, Link, Model, Plugin
from simulation_tools.vehicle.airframe import Airframe
from simulation_tools.vehicle.rotor import AirframeError, Rotor
from simulation_tools.vehicle.rotor_plugins import BODY_DRAG, LINEAR_ROTOR, MOTOR_MODEL, centre_of_mass

DT = 0.004
PROPELLER = Rotor(
    joint="rotor_0_joint",
    position_m=(0.13, -0.22, 0.02),
    direction=1.0,
    idle=100.0,
    top=1100.0,
    time_constant_up_s=0.0125,
    time_constant_down_s=0.025,
    thrust_quadratic=5.84e-6,
    thrust_linear=0.0,
    moment_m=0.06,
    rotor_drag=1.75e-4,
    rolling_moment=1e-6,
)


def steady(airframe, commands, velocity=(0.0, 0.0, 0.0), wind=(0.0, 0.0, 0.0)):
    """Force and torque once the rotors have caught up."""
    for _ in range(500):
        force, torque = airframe.step(np.asarray(commands, dtype=float), velocity, DT, wind)
    return np.array(force), np.array(torque)


def slow_reference(rotors, speeds, air, drag):
    """The same forces from vectors and cross products."""
    force = -drag * np.linalg.norm(air) * np.asarray(air)
    torque = np.zeros(3)
    across = np.array([air[0], air[1], 0.0])
    for rotor, x in zip(rotors, speeds):
        thrust = rotor.thrust_quadratic * x**2 + rotor.thrust_linear * x
        f = np.array([0.0, 0.0, thrust]) - x * rotor.rotor_drag * across
        force = force + f
        torque = torque + np.cross(rotor.position_m, f) - x * rotor.rolling_moment * across
        torque[2] -= rotor.direction * rotor.moment_m * thrust
    return force, torque


def test_full_command_gives_top_speed_and_its_thrust():
    airframe = Airframe([PROPELLER])
    force, torque = steady(airframe, [1.0])
    assert airframe.rotor_states[0] == pytest.approx(1100.0)
    assert force[2] == pytest.approx(5.84e-6 * 1100.0**2)
    # Thrust at (0.13, -0.22): about x y F, about y -x F; counter-clockwise rotors turn the body clockwise.
    assert torque == pytest.approx([-0.22 * force[2], -0.13 * force[2], -0.06 * force[2]])


def test_rotors_lag_as_first_order_faster_up_than_down():
    airframe = Airframe([PROPELLER])
    airframe.step(np.ones(1), (0, 0, 0), DT)
    assert airframe.rotor_states[0] == pytest.approx(1100.0 * (1.0 - math.exp(-DT / 0.0125)))
    steady(airframe, [1.0])
    airframe.step(np.zeros(1), (0, 0, 0), DT)
    assert airframe.rotor_states[0] == pytest.approx(1100.0 * math.exp(-DT / 0.025))


def test_the_lag_does_not_depend_on_the_step():
    fine, coarse = Airframe([PROPELLER]), Airframe([PROPELLER])
    coarse.step(np.ones(1), (0, 0, 0), 0.008)
    for _ in range(8):
        fine.step(np.ones(1), (0, 0, 0), 0.001)
    assert fine.rotor_states[0] == pytest.approx(coarse.rotor_states[0])


@pytest.mark.table("command", [0.0, -1.0, math.nan])
def test_no_command_stops_the_rotor(command):
    airframe = Airframe([PROPELLER])
    steady(airframe, [1.0])
    force, _ = steady(airframe, [command])
    assert airframe.rotor_states[0] == pytest.approx(0.0, abs=1e-9)
    assert force[2] == pytest.approx(0.0, abs=1e-12)


def test_command_for_thrust_inverts_the_thrust():
    for thrust in (0.5, 3.0, 6.0):
        force, _ = steady(Airframe([PROPELLER]), [PROPELLER.command_for_thrust(thrust)])
        assert force[2] == pytest.approx(thrust)


def test_hover_command_of_the_iris_in_closed_form():
    airframe = Airframe([replace(PROPELLER, joint=f"rotor_{i}") for i in range(4)])
    # 4 k (100 + 1000 u)^2 = m g
    expected = (math.sqrt(1.63 * 9.8 / (4 * 5.84e-6)) - 100.0) / 1000.0
    assert airframe.hover_command(1.63) == pytest.approx(expected)


def test_wind_and_velocity_count_by_their_difference():
    moving = steady(Airframe([PROPELLER], 0.01), [0.7], velocity=(1.0, -2.0, 0.5))
    blown = steady(Airframe([PROPELLER], 0.01), [0.7], wind=(-1.0, 2.0, -0.5))
    together = steady(Airframe([PROPELLER], 0.01), [0.7], velocity=(3.0, 1.0, 2.0), wind=(3.0, 1.0, 2.0))
    assert moving[0] == pytest.approx(blown[0])
    assert together[0][:2] == pytest.approx([0.0, 0.0])


@given(
    commands=st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3),
    air=st.tuples(*[st.floats(-15.0, 15.0)] * 3),
    drag=st.floats(0.0, 0.1),
)
def test_the_kernel_equals_the_slow_reference(commands, air, drag):
    rotors = [
        PROPELLER,
        replace(PROPELLER, position_m=(-0.1, 0.2, -0.03), direction=-1.0),
        Rotor("linear", (0.1, 0.1, 0.0), 1.0, 0.0, 1.0, 0.005, 0.005, 0.0, 4.0, 0.0125),
    ]
    airframe = Airframe(rotors, drag)
    for _ in range(3):
        force, torque = airframe.step(np.array(commands), air, DT)
    expected_force, expected_torque = slow_reference(rotors, airframe.rotor_states, air, drag)
    assert force == pytest.approx(expected_force, abs=1e-12)
    assert torque == pytest.approx(expected_torque, abs=1e-12)


def test_reset_stops_the_rotors():
    airframe = Airframe([PROPELLER])
    steady(airframe, [1.0])
    airframe.reset()
    assert airframe.rotor_states[0] == 0.0


# From SDF


def link(name, pose=None, mass=0.1):
    return Link(name, pose or Pose.identity(), Inertial(mass, Pose.identity(), (1e-3,) * 3 + (0.0,) * 3))


def linear_plugin(number, **changes):
    parameters = {
        "jointName": f"joint_{number}",
        "linkName": f"rotor_{number}",
        "motorNumber": str(number),
        "turningDirection": "ccw",
        "maxThrust": "4.0",
        "maxTorque": "0.05",
        "timeConstant": "0.005",
    }
    parameters.update(changes)
    parameters = {key: value for key, value in parameters.items() if value is not None}
    return Plugin(f"motor_{number}", LINEAR_ROTOR, parameters, line=17)


def model(*plugins):
    rotors = [link(f"rotor_{i}", Pose((0.1 * (i + 1), 0.0, 0.05)), mass=0.1) for i in range(2)]
    joints = tuple(Joint(f"joint_{i}", "revolute", "base", f"rotor_{i}") for i in range(2))
    return Model(
        "quad", Pose.identity(), False, (link("base", mass=0.8), *rotors), joints, plugins, source="quad.sdf"
    )


def test_rotors_are_read_by_number_and_placed_from_the_centre_of_mass():
    airframe = Airframe.from_sdf(model(linear_plugin(1, turningDirection="cw"), linear_plugin(0)))
    centre = (0.1 * 0.1 + 0.1 * 0.2) / 1.0
    assert centre_of_mass(model()) == pytest.approx((centre, 0.0, 0.01))
    assert [rotor.direction for rotor in airframe.rotors] == [1.0, -1.0]
    assert airframe.rotors[0].position_m == pytest.approx((0.1 - centre, 0.0, 0.04))
    assert airframe.rotor_joints == {"joint_0", "joint_1"}
    assert (airframe.rotors[0].thrust_linear, airframe.rotors[0].top) == (4.0, 1.0)


def test_gazebos_motor_model_and_body_drag_are_read():
    plugin = linear_plugin(0)
    parameters = {
        **plugin.parameters,
        "maxRotVelocity": "1100",
        "timeConstantUp": "0.0125",
        "timeConstantDown": "0.025",
        "motorConstant": "5.84e-06",
        "momentConstant": "0.06",
        "rotorDragCoefficient": "0.000175",
    }
    drag = Plugin("drag", BODY_DRAG, {"quadraticDrag": "0.01"})
    airframe = Airframe.from_sdf(model(replace(plugin, filename=MOTOR_MODEL, parameters=parameters), drag))
    rotor = airframe.rotors[0]
    assert (rotor.idle, rotor.top) == (100.0, 1100.0)
    assert (rotor.thrust_quadratic, rotor.moment_m, rotor.rotor_drag) == (5.84e-6, 0.06, 1.75e-4)
    assert airframe.body_drag == 0.01


@pytest.mark.table(
    ("plugins", "complaint"),
    [
        ((), "without gaps"),
        ((linear_plugin(1),), "without gaps"),
        ((linear_plugin(0), linear_plugin(0)), "twice"),
        ((linear_plugin(0, maxThrust=None),), "<maxThrust> is missing"),
        ((linear_plugin(0, maxThrust="four"),), "must be a number"),
        ((linear_plugin(0, timeConstant="nan"),), "must be finite"),
        ((linear_plugin(0, timeConstant="-1"),), "time_constant_up_s must be greater than 0, not -1"),
        ((linear_plugin(0, maxThrust="0"),), "its thrust is 0 at any speed"),
        ((linear_plugin(0, turningDirection="left"),), "cw or ccw"),
        ((linear_plugin(0, linkName="nothing"),), "no link or joint"),
    ],
)
def test_a_bad_plugin_is_named_in_one_sentence(plugins, complaint):
    with pytest.raises(AirframeError, match=complaint) as caught:
        Airframe.from_sdf(model(*plugins))
    assert "\n" not in str(caught.value)
