"""The hold in three dimensions and the ballast tank: closed, as large as asked, and with ways through."""

import numpy as np
import pytest

from flights.errors import ScenarioError
from flights.worlds import floor_plan, generator
from flights.worlds.ballast_tank import BallastTankParameters, ballast_tank
from flights.worlds.cargo import NAMES
from flights.worlds.hold_3d import Hold3DParameters, hold_3d, hold_3d_cargo
from simulation_tools.sdf.parser import load_world
from simulation_tools.world.rays import RayScene
from simulation_tools.world.shapes.meshes import mesh_of
from simulation_tools.world.shapes.triangle_mesh import joined

FAR_M = 100.0
START = (-9.0, 5.0)
"""Of explore.launch and inspection.launch in the hold."""


def world_of(text, folder):
    path = folder / "drawn.world"
    path.write_text(text)
    return load_world(str(path), ())


def rays_into(world):
    """Return a function: distance to the nearest surface from a place, along directions (n, 3)."""
    meshes = [
        mesh_of(each.geometry).transformed(model.pose @ link.pose @ each.pose)
        for model in world.models
        for link in model.links
        for each in link.collisions
    ]
    scene = RayScene()
    scene.put("all", joined(meshes))

    def cast(origin, directions):
        return scene.cast(np.asarray(origin, float), np.asarray(directions, float), FAR_M)

    return cast


@pytest.fixture(scope="module")
def worlds(tmp_path_factory):
    folder = tmp_path_factory.mktemp("worlds")
    return {
        "hold_3d": world_of(hold_3d(), folder),
        "hold_3d_cargo": world_of(hold_3d_cargo(), folder),
        "ballast_tank": world_of(ballast_tank(), folder),
        "wide tank": world_of(ballast_tank(BallastTankParameters(2, 5.0, 4.0, 4.0)), folder),
        "small hold": world_of(hold_3d(Hold3DParameters(16.0, 12.0, 6.0, hatch_length_m=6.0)), folder),
    }


@pytest.mark.table(
    ("name", "size_m"),
    [
        ("hold_3d", (30.0, 20.0, 11.2)),
        ("hold_3d_cargo", (30.0, 20.0, 11.2)),
        ("ballast_tank", (20.0, 3.0, 5.2)),
        ("wide tank", (10.0, 4.0, 4.2)),
    ],
)
def test_nothing_leaves_it_and_it_has_its_size(worlds, name, size_m):
    """Seen from near the middle in 20,000 directions, by Embree."""
    rng, cast = np.random.default_rng(0), rays_into(worlds[name])
    directions = rng.normal(size=(20_000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    origin = np.array([0.31, 0.22, 2.0])
    ranges_m = cast(origin, directions)
    assert np.isfinite(ranges_m).all()
    ends = origin + ranges_m[:, None] * directions
    assert (np.abs(ends[:, :2]) <= np.array(size_m[:2]) / 2 + 1e-3).all()
    assert ends[:, 2].min() >= -1e-3
    assert ends[:, 2].max() <= size_m[2] + 1e-3


def test_the_simulator_knows_everything_in_them(worlds):
    for world in worlds.values():
        assert world.warnings == ()


def test_the_hold_has_webs_every_3_m_a_coaming_a_ladder_and_three_stanchions(worlds):
    parts = {
        model.name: [each.name for each in model.links[0].collisions] for model in worlds["hold_3d"].models
    }
    assert sum(name.startswith("web_port") for name in parts["frames"]) == 9  # at 3, 6, ... 27 of 30 m
    assert (len(parts["coaming"]), len(parts["stanchions"])) == (4, 3)
    assert sum(name.startswith("rail") for name in parts["ladder"]) == 2
    cast = rays_into(worlds["hold_3d"])
    up = cast((0.0, 0.0, 2.0), [(0.0, 0.0, 1.0)])[0]
    assert up == pytest.approx(9.0)  # through the hatch to its cover
    web_m, flange_m = 0.5, 0.05
    assert cast((0.0, 0.0, 5.0), [(0.0, 1.0, 0.0)])[0] == pytest.approx(10.0 - web_m - flange_m)
    assert cast((1.0, 0.0, 5.0), [(0.0, 1.0, 0.0)])[0] == pytest.approx(10.0)


def test_cargo_hides_a_part_of_the_hold_and_leaves_ways_around_it(worlds):
    cast = rays_into(worlds["hold_3d_cargo"])
    # Two containers of 2.591 m, 2.438 m wide, stand with their middle at y = 7.25 m, between two frames
    for height_m, away_m in ((1.0, 7.25 - 1.219), (5.1, 7.25 - 1.219), (5.3, 10.0)):
        assert cast((5.0, 0.0, height_m), [(0.0, 1.0, 0.0)])[0] == pytest.approx(away_m, abs=1e-3)


def test_a_uav_gets_around_the_cargo(worlds):
    groups = {}
    for each in floor_plan.outlines(worlds["hold_3d_cargo"]):
        if each.blocks(0.5):
            model = each.name.split("::")[0]
            groups.setdefault(model if model in NAMES else "ship", []).append(along(each.outline_xy))
    assert groups.keys() == {"ship", *NAMES}
    places = {name: np.concatenate(parts) for name, parts in groups.items()}
    for name in NAMES:
        others = np.concatenate([own for other, own in places.items() if other != name])
        apart_m = np.linalg.norm(places[name][:, None] - others, axis=2).min()
        assert apart_m > 0.9, name
        assert np.linalg.norm(places[name] - START, axis=1).min() > 1.5


def along(corners, step_m=0.1):
    """Places along the outline of corners (n, 2)."""
    ends = zip(corners, np.roll(corners, -1, axis=0))
    return np.concatenate([np.linspace(a, b, 2 + int(np.linalg.norm(b - a) / step_m)) for a, b in ends])


@pytest.mark.table("bulkhead", range(4))
def test_a_manhole_is_0_6_x_0_8_m_and_lies_to_port_and_starboard_by_turns(worlds, bulkhead):
    p = BallastTankParameters()
    y = 0.7 if bulkhead % 2 == 0 else -0.7
    middle = (p.bulkheads_x_m[bulkhead], y, p.sill_m + 0.4)
    cast = rays_into(worlds["ballast_tank"])
    to_edges = cast(middle, [(0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)])
    assert to_edges == pytest.approx([0.3, 0.3, 0.4, 0.4], abs=1e-3)
    assert cast(middle, [(1, 0, 0), (-1, 0, 0)]).min() > 3.9  # into both compartments
    assert cast((middle[0] - 1.0, -y, middle[2]), [(1, 0, 0)])[0] == pytest.approx(1.0 - 0.015, abs=1e-3)


def test_a_world_is_drawn_with_sizes_of_ones_own():
    assert generator.make("ballast_tank", {"compartments": 3}) == ballast_tank(BallastTankParameters(3))


@pytest.mark.table(
    ("name", "sizes", "complaint"),
    [
        ("hold", {"length_m": 40.0}, "'hold' has no parameters"),
        ("hold_3d", {"depth": 1.0}, "no parameter depth"),
    ],
)
def test_a_size_that_a_world_does_not_have_is_refused(name, sizes, complaint):
    with pytest.raises(ScenarioError, match=complaint):
        generator.make(name, sizes)
