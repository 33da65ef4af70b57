"""Quaternion arithmetic against rotation matrices written out."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_basics.errors import PoseError
from flight_basics.geometry import heading_rate, multiply, normalised, rotate, yaw_of

component = st.floats(-1.0, 1.0)
rotation = (
    st.tuples(component, component, component, component)
    .filter(lambda q: sum(c * c for c in q) > 1e-3)
    .map(lambda q: normalised(q))
)


def matrix(q):
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@given(a=rotation, b=rotation, vector=st.tuples(component, component, component))
def test_rotation_and_product_equal_the_matrices(a, b, vector):
    np.testing.assert_allclose(rotate(a, vector), matrix(a) @ vector, atol=1e-12)
    np.testing.assert_allclose(matrix(multiply(a, b)), matrix(a) @ matrix(b), atol=1e-12)


@given(yaw=st.floats(-3.1, 3.1), pitch=st.floats(-1.5, 1.5), roll=st.floats(-3.0, 3.0))
def test_yaw_of_a_tilted_body(yaw, pitch, roll):
    def about(axis, angle):
        q = [0.0, 0.0, 0.0, math.cos(angle / 2)]
        q[axis] = math.sin(angle / 2)
        return tuple(q)

    tilted = multiply(multiply(about(2, yaw), about(1, pitch)), about(0, roll))
    assert yaw_of(tilted) == pytest.approx(yaw, abs=1e-9)


@pytest.mark.table("bad", [(0.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0), (math.inf, 0.0, 0.0, 1.0)])
def test_refuses_what_is_no_rotation(bad):
    with pytest.raises(PoseError, match="not a rotation"):
        normalised(bad)


@given(rotation, st.tuples(*[st.floats(-3.0, 3.0)] * 3))
def test_the_heading_turns_as_fast_as_the_yaw_changes(q, rates):
    step_s = 1e-6
    turned = multiply(q, normalised((*(0.5 * step_s * rate for rate in rates), 1.0)))
    if math.hypot(*matrix(q)[:2, 0]) > 0.1:  # else the x axis points up or down
        change = math.remainder(yaw_of(turned) - yaw_of(q), 2.0 * math.pi)
        assert heading_rate(q, rates) == pytest.approx(change / step_s, abs=1e-3)


def test_what_points_straight_up_has_no_heading():
    assert math.isnan(heading_rate((0.0, -math.sqrt(0.5), 0.0, math.sqrt(0.5)), (1.0, 1.0, 1.0)))
