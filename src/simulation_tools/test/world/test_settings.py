"""Each setting of the physics takes effect in a running world, and outlives its reset."""

import math

import pytest

from simulation_tools.geometry import Pose
from simulation_tools.world.settings import ContactSolver
from simulation_tools.world.world import WorldError

from .conftest import solid_box

DT = 0.004


def height(world, name="thing"):
    return world.get_state(name).pose.position_m[2]


def stacked(build, solver):
    """Height in m of a box of 10 kg, 2 s after it was put onto seven of 1 kg, each 0.2 m high."""
    world = build(ground=True)
    world.settings.solver = solver
    for level in range(8):
        box = solid_box(0.2, 0.2, 0.2, 10.0 if level == 7 else 1.0)
        world.spawn(box, f"box_{level}", Pose((0.0, 0.0, 0.1 + 0.2 * level)))
    for _ in range(500):
        world.step()
    return height(world, "box_7")


def height_of_overlapping(build, solver, steps, overlap_m=0.05):
    """Height in m of the centre of a 0.2 m box that begins with its bottom in the ground."""
    world = build(ground=True)
    world.settings.solver = solver
    world.spawn(solid_box(0.2, 0.2, 0.2, 1.0), "thing", Pose((0.0, 0.0, 0.1 - overlap_m)))
    for _ in range(steps):
        world.step()
    return height(world)


def test_gravity_is_what_a_body_falls_by(build):
    world = build(solid_box(1, 1, 1, 1))
    world.settings.gravity_m_s2 = (1.0, 2.0, -3.0)
    for _ in range(100):
        world.step()
    place = world.get_state("thing").pose.position_m
    sums = 100 * 101 / 2 * DT**2  # each step adds its own velocity
    assert place == pytest.approx((1.0 * sums, 2.0 * sums, -3.0 * sums), rel=1e-3)
    world.reset()
    world.step()
    assert world.get_state("thing").linear_velocity_m_s == pytest.approx((DT, 2 * DT, -3 * DT), rel=1e-3)


def test_more_iterations_hold_a_stack_that_few_let_collapse(build):
    assert stacked(build, ContactSolver()) == pytest.approx(1.5, abs=0.01)
    assert stacked(build, ContactSolver(iterations=1)) < 0.5


def test_a_solver_that_stops_early_lets_the_stack_collapse(build):
    assert stacked(build, ContactSolver(residual_m_s=1.0)) < 0.5


def test_constraint_force_mixing_makes_contacts_soft(build):
    hard = height_of_overlapping(build, ContactSolver(), 60)
    assert height_of_overlapping(build, ContactSolver(cfm=0.001), 60) < hard - 1e-4


def test_error_reduction_pushes_overlapping_bodies_apart(build):
    kept = height_of_overlapping(build, ContactSolver(erp=0.0), 60)
    assert kept == pytest.approx(0.05, abs=2e-4)
    slow, fast = (
        height_of_overlapping(build, ContactSolver(erp=erp), 1) - 0.05 + 9.8 * DT**2 for erp in (0.04, 0.16)
    )
    assert fast / slow == pytest.approx(4.0, rel=0.1)  # proportional


def test_bodies_at_rest_sink_by_the_surface_layer(build):
    deep = height_of_overlapping(build, ContactSolver(surface_layer_m=0.01), 500, overlap_m=0.0)
    assert deep == pytest.approx(0.1 - 0.01, abs=1e-3)
    assert height_of_overlapping(build, ContactSolver(), 500, overlap_m=0.0) == pytest.approx(0.1, abs=1e-3)


def test_a_reset_keeps_how_contacts_are_solved(build):
    world = build(solid_box(0.2, 0.2, 0.2, 1.0), ground=True)
    world.settings.solver = ContactSolver(surface_layer_m=0.01)
    world.reset()
    for _ in range(500):
        world.step()
    assert height(world) == pytest.approx(0.09, abs=1e-3)


def test_gravity_that_is_not_finite_is_refused_and_the_old_one_stays(build):
    world = build(solid_box(1, 1, 1, 1))
    with pytest.raises(WorldError, match="Gravity"):
        world.settings.gravity_m_s2 = (0.0, math.nan, 0.0)
    world.step()
    assert world.get_state("thing").linear_velocity_m_s[2] == pytest.approx(-9.8 * DT)
