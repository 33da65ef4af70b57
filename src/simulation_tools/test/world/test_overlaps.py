"""Models that are inside each other are named before physics throws them apart; what is static stays."""

from __future__ import annotations

import pytest

from simulation_tools.geometry import Pose
from simulation_tools.simulation import Simulation, SimulationParameters
from simulation_tools.world.overlaps import warning_of

from .conftest import GROUND, box, mass, model, shape, solid_box, still_box

TRUNK = "<cylinder><radius>0.2</radius><length>4</length></cylinder>"


def at(x: float, one, z: float = 0.5):
    return one.placed(pose=Pose.from_xyz_rpy(x, 0, z))


def test_it_names_who_is_inside_whom_and_how_deep(build):
    world = build(
        at(0.0, solid_box(1, 1, 1, 1, "a")),
        at(0.7, solid_box(1, 1, 1, 1, "b")),  # 0.3 m inside a
        at(3.0, still_box(1, 1, 1, "wall")),
        at(3.9, solid_box(1, 1, 1, 1, "c")),  # 0.1 m inside the wall
        at(3.0, still_box(1, 1, 1, "wall_2")),  # both stand: nothing happens
        at(7.0, solid_box(1, 1, 1, 1, "d")),
        at(8.0, solid_box(1, 1, 1, 1, "e")),  # they touch
        ground=True,
    )
    found = {(one.first, one.second): one.depth_m for one in world.overlaps()}
    assert found == {
        ("a", "b"): pytest.approx(0.3, abs=0.01),
        ("c", "wall"): pytest.approx(0.1, abs=0.01),
        ("c", "wall_2"): pytest.approx(0.1, abs=0.01),
    }
    assert warning_of(world.overlaps()).startswith(
        "Models that can move are inside others at the start (a and b by 0.30 m, c and wall"
    )
    assert warning_of([]) is None


def forest(folder) -> str:
    """A foreign forest: light trunks that can move, each inside the next."""
    trunk = f'<link name="l">{mass(1.0, 1.4, 1.4, 0.02)}{shape(TRUNK)}</link>'
    models = "".join(
        f'<model name="trunk_{number}"><pose>{0.3 * number:g} 5 2.01 0 0 0</pose>{trunk}</model>'
        for number in range(5)
    )
    path = folder / "forest.world"
    ground = f'<model name="ground_plane">{GROUND}</model>'
    path.write_text(f'<sdf version="1.6"><world name="w">{ground}{models}</world></sdf>')
    return str(path)


def moved_m(simulation) -> float:
    """How far the farthest trunk is from its place after half a second."""
    simulation.sense()
    for _ in range(125):
        simulation.step()
    places = [simulation.world.get_state(f"trunk_{number}").pose.position_m for number in range(5)]
    return max(abs(x - 0.3 * number) + abs(y - 5.0) for number, (x, y, _) in enumerate(places))


@pytest.mark.table("static_models", [False, True])
def test_overlapping_trunks_are_warned_of_and_stand_when_told_to(tmp_path, static_models):
    simulation = Simulation(SimulationParameters(forest(tmp_path), static_models=static_models))
    try:
        told = [warning for warning in simulation.warnings if ": physics throws them apart" in warning]
        if static_models:
            assert told == []
            assert moved_m(simulation) < 1e-9
        else:
            assert "trunk_0 and trunk_1 by 0.1" in told[0]
            assert "pairs more" in told[0] or "trunk_3 and trunk_4" in told[0]
            assert "static_models:=true" in told[0]
            assert moved_m(simulation) > 0.05
    finally:
        simulation.close()


@pytest.mark.parametrize("static", [False, True])
def test_a_static_model_within_one_that_moves_stays_where_it_is(build, static):
    post = f'<model name="post"><static>{str(static).lower()}</static><link name="p">{mass(1, 1, 1, 1)}'
    post += f"{shape(box(0.1, 0.1, 0.1))}</link></model>"
    crate = f'<link name="l"><pose>2 0 0 0 0 0</pose>{mass(1, 1, 1, 1)}{shape(box(0.1, 0.1, 0.1))}</link>'
    world = build(at(0.0, model(crate + post), z=5.0))
    for _ in range(50):
        world.step()
    assert world.link_state("thing", "l").pose.position_m[2] < 4.9
    assert (world.link_state("thing", "post::p").pose.position_m[2] == 5.0) is static
