"""Mass, centre of mass and inertia of lumped links against sums worked out by hand; how models are split."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.geometry import Pose, rotation_matrix
from simulation_tools.sdf.elements import Inertial
from simulation_tools.sdf.parser import parse_model
from simulation_tools.world.assembly import assemblies, combined

POINT = (1e-9, 1e-9, 1e-9, 0.0, 0.0, 0.0)


def test_a_dumbbell_of_two_point_masses():
    # 1 kg at x = 0 and 3 kg at x = 4: centre at 3, inertia m1 m2 / (m1 + m2) d^2 = 12 about y and z.
    body = combined(
        [(Inertial(1.0, Pose(), POINT), Pose()), (Inertial(3.0, Pose(), POINT), Pose.from_xyz_rpy(4, 0, 0))]
    )
    assert body.mass_kg == 4.0
    np.testing.assert_allclose(body.centre_m, (3.0, 0.0, 0.0))
    np.testing.assert_allclose(body.inertia_kg_m2, np.diag((0.0, 12.0, 12.0)), atol=1e-8)


def test_a_rod_made_of_two_halves_has_the_inertia_of_the_whole():
    # A rod of mass m and length L has m L^2 / 12 about its middle; its halves (m/2, L/2) must add up to that.
    half = Inertial(0.5, Pose(), (1e-12, 0.5 * 1.0**2 / 12, 0.5 * 1.0**2 / 12, 0.0, 0.0, 0.0))
    body = combined([(half, Pose.from_xyz_rpy(-0.5, 0, 0)), (half, Pose.from_xyz_rpy(0.5, 0, 0))])
    np.testing.assert_allclose(np.diag(body.inertia_kg_m2)[1:], 1.0 * 2.0**2 / 12, atol=1e-12)


def test_the_links_pose_and_the_inertials_pose_both_count():
    # A quarter turn about z swaps the moments about x and y.
    inertial = Inertial(
        2.0, Pose.from_xyz_rpy(1, 0, 0, 0, 0, math.pi / 2), (1.0, 2.0, 3.0 - 1e-9, 0.0, 0.0, 0.0)
    )
    body = combined([(inertial, Pose.from_xyz_rpy(0, 5, 0))])
    np.testing.assert_allclose(body.centre_m, (1.0, 5.0, 0.0))
    np.testing.assert_allclose(np.diag(body.inertia_kg_m2), (2.0, 1.0, 3.0), atol=1e-8)


@given(
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.tuples(*[st.floats(0.1, 2.0)] * 3),
    st.tuples(*[st.floats(-2.0, 2.0)] * 3),
)
def test_principal_moments_and_axes_give_the_inertia_back(rpy, squares, place):
    # Moments of three point pairs, so that they satisfy the triangle inequality.
    a, b, c = squares
    inertial = Inertial(1.0, Pose.from_xyz_rpy(*place, *rpy), (b + c, a + c, a + b, 0.0, 0.0, 0.0))
    body = combined([(inertial, Pose())])
    frame, moments = body.principal()
    turn = rotation_matrix(frame.orientation_xyzw)
    np.testing.assert_allclose(turn @ np.diag(moments) @ turn.T, body.inertia_kg_m2, atol=1e-9)
    np.testing.assert_allclose(frame.position_m, body.centre_m)


def test_a_body_without_products_of_inertia_keeps_its_axes():
    body = combined([(Inertial(1.0, Pose(), (3.0, 1.0, 2.0, 0.0, 0.0, 0.0)), Pose())])
    frame, moments = body.principal()
    assert frame.orientation_xyzw == (0.0, 0.0, 0.0, 1.0)
    assert moments == (3.0, 1.0, 2.0)


def model(joints: str, static: str = "false"):
    links = "".join(f'<link name="{name}"><pose>{k} 0 0 0 0 0</pose></link>' for k, name in enumerate("abcd"))
    return parse_model(
        f'<sdf version="1.6"><model name="m"><static>{static}</static>{links}{joints}</model></sdf>', "t", []
    )


def joint(name, kind, parent, child):
    axis = "<axis><xyz>0 0 1</xyz></axis>" if kind == "revolute" else ""
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{axis}</joint>'


def names(assembly):
    return [[link.name for link in part.links] for part in assembly]


def test_fixed_joints_lump_and_revolute_joints_part():
    chain = (
        joint("ab", "fixed", "a", "b") + joint("bc", "revolute", "b", "c") + joint("cd", "fixed", "c", "d")
    )
    (whole,) = assemblies(model(chain))
    assert names(whole) == [["a", "b"], ["c", "d"]]
    assert whole[1].parent == 0
    assert whole[1].pose.position_m == (2.0, 0.0, 0.0)
    np.testing.assert_allclose(whole[1].mass.centre_m, (0.5, 0.0, 0.0))
    (lumped,) = assemblies(model(chain), frozenset({"bc"}))
    assert names(lumped) == [["a", "b", "c", "d"]]


def test_links_without_a_joint_are_bodies_and_the_first_one_leads():
    parts = assemblies(model(joint("dc", "fixed", "d", "c")))
    assert [names(assembly) for assembly in parts] == [[["a"]], [["b"]], [["c", "d"]]]


def test_the_first_link_may_hang_on_a_later_one():
    first, *others = assemblies(model(joint("da", "revolute", "d", "a")))
    assert names(first) == [["d"], ["a"]]
    assert len(others) == 2


@pytest.mark.table("kind", ["fixed", "revolute"])
def test_a_joint_to_the_world_holds_the_model(kind):
    first = assemblies(model(joint("wa", kind, "world", "a")))[0]
    assert first[0].mass is None
    assert names(first) == ([["a"]] if kind == "fixed" else [[], ["a"]])


def test_a_static_model_is_one_part_that_cannot_move():
    (parts,) = assemblies(model(joint("ab", "revolute", "a", "b"), static="true"))
    assert names(parts) == [["a", "b", "c", "d"]]
    assert parts[0].mass is None
