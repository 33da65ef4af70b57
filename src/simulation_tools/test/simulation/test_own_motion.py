"""The UAV's motion in its own axes, against the functions of `geometry` and `imu`."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.geometry import Pose, rotate_inverse
from simulation_tools.sensors.imu import specific_force
from simulation_tools.simulation.own_motion import own_motion
from simulation_tools.world.kinematics import BodyState

numbers = st.floats(-20.0, 20.0)
vectors = st.tuples(numbers, numbers, numbers)


@given(vectors, vectors, vectors, vectors, st.sampled_from([0.001, 0.004, 0.008]))
def test_it_is_the_motion_in_the_world_turned_into_the_body(rpy, before, velocity, spin, dt_s):
    gravity = (0.0, 0.0, -9.8)
    now = BodyState(Pose.from_xyz_rpy(1.0, 2.0, 3.0, *rpy), velocity, spin)
    q = now.pose.orientation_xyzw
    assert own_motion(before, now, dt_s, gravity) == (
        rotate_inverse(q, velocity),
        rotate_inverse(q, spin),
        specific_force(before, velocity, dt_s, gravity, q),
    )
