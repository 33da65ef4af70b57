"""Heightmaps: heights, orientation and scale against what was drawn; bad pictures; rays and balls on them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from PIL import Image

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Heightmap
from simulation_tools.sdf.parser import SdfError, parse_model
from simulation_tools.world.shapes.meshes import mesh_of
from simulation_tools.world.shapes.terrain import MeshError

TERRAIN = (
    '<sdf version="1.6"><model name="t"><static>1</static><link name="l"><collision name="c"><geometry>'
    "<heightmap><uri>{}</uri><size>{}</size><pos>{}</pos><texture/></heightmap></geometry></collision>"
    "</link></model></sdf>"
)


@pytest.fixture
def ramp(tmp_path):
    """A picture of 65 x 65: rises from left to right up to its half, twice as steeply from bottom to top."""
    columns, rows = np.meshgrid(np.arange(65), np.arange(65))
    picture = (columns + 2 * (64 - rows)) * 200
    path = tmp_path / "ramp.png"
    Image.fromarray(picture.astype(np.uint16)).save(path)
    return path


def height(x, y):
    """Of the ramp, 64 m wide and 6 m high at its brightest corner, with its foot at z = 1."""
    return 1.0 + 6.0 * ((x + 32) + 2 * (y + 32)) / (64 + 128)


def spawn_ramp(world, ramp):
    model = parse_model(TERRAIN.format(ramp, "64 64 6", "0 0 1"), "t", [ramp.parent])
    assert model.warnings == ()
    world.spawn(model, "t", Pose())


def test_a_ray_down_meets_the_height_that_was_drawn(build, ramp):
    world = build()
    spawn_ramp(world, ramp)
    rng = np.random.default_rng(1)
    places = np.column_stack((rng.uniform(-31.9, 31.9, (500, 2)), np.full(500, 20.0)))
    down = np.tile((0.0, 0.0, -1.0), (500, 1))
    ranges = world.rays.cast(places, down, 50.0)
    np.testing.assert_allclose(20.0 - ranges, height(places[:, 0], places[:, 1]), atol=1e-3)


def test_a_ball_rolls_down_the_steepest_way(build, ramp):
    world = build()
    spawn_ramp(world, ramp)
    ball = parse_model(
        '<sdf version="1.6"><model name="b"><link name="l"><inertial><mass>1</mass><inertia><ixx>.016</ixx>'
        '<iyy>.016</iyy><izz>.016</izz></inertia></inertial><collision name="c"><geometry><sphere><radius>.2'
        "</radius></sphere></geometry></collision></link></model></sdf>",
        "b",
        [],
    )
    slope = math.hypot(6 / 192, 12 / 192)
    start = height(0.0, 0.0) + 0.2 * math.hypot(1.0, slope)
    world.spawn(ball, "b", Pose((0.0, 0.0, start)))
    for _ in range(500):
        world.step()
    x, y, z = world.get_state("b").pose.position_m
    # It rolls without sliding: a = g sin / (1 + 2/5), along (1, 2) downhill.
    way = 0.5 * 9.8 * slope / math.hypot(1.0, slope) / 1.4 * 2.0**2
    assert math.hypot(x, y) == pytest.approx(way * math.cos(math.atan(slope)), rel=0.1)
    # Bullet lets the edges between triangles push a little to the side.
    assert math.atan2(y, x) == pytest.approx(math.atan2(-2.0, -1.0), abs=math.radians(6.0))
    assert z == pytest.approx(height(x, y) + 0.2, abs=0.02)


def test_eight_and_sixteen_bits_say_the_same(tmp_path):
    rng = np.random.default_rng(2)
    grey = rng.integers(0, 256, (17, 17))
    grey[3, 4] = 255
    paths = [tmp_path / "8.png", tmp_path / "16.png"]
    Image.fromarray(grey.astype(np.uint8)).save(paths[0])
    Image.fromarray((257 * grey).astype(np.uint16)).save(paths[1])
    a, b = (mesh_of(Heightmap(str(path), "", (4.0, 4.0, 2.0))).vertices for path in paths)
    np.testing.assert_allclose(a, b, atol=1e-9)
    assert a[:, 2].max() == pytest.approx(2.0)


@pytest.mark.parametrize("shape", [(16, 16), (17, 33), (2, 2), (2049, 2049)])
def test_a_picture_that_gazebo_would_refuse_is_refused(build, tmp_path, shape):
    path = tmp_path / "bad.png"
    Image.fromarray(np.zeros(shape, np.uint8)).save(path)
    model = parse_model(TERRAIN.format(path, "1 1 1", "0 0 0"), "t", [tmp_path])
    with pytest.raises(MeshError, match=r"bad.png: A heightmap must be a square"):
        build().spawn(model, "t", Pose())


def test_a_file_that_is_no_picture_is_refused(build, tmp_path):
    path = tmp_path / "text.png"
    path.write_text("not a picture")
    model = parse_model(TERRAIN.format(path, "1 1 1", "0 0 0"), "t", [tmp_path])
    with pytest.raises(MeshError, match="cannot be read"):
        build().spawn(model, "t", Pose())


@pytest.mark.parametrize(
    ("uri", "size", "words"),
    [
        ("model://none/x.png", "1 1 1", "heightmap cannot be loaded"),
        ("{}/ramp.png", "1 1 0", "positive numbers only"),
        ("{}/ramp.txt", "1 1 1", "does not exist"),
    ],
)
def test_a_bad_heightmap_is_refused_with_its_place(ramp, uri, size, words):
    with pytest.raises(SdfError, match=words):
        parse_model(TERRAIN.format(uri.format(ramp.parent), size, "0 0 0"), "t", [ramp.parent])


def test_terrain_cannot_move(build, ramp):
    model = parse_model(
        TERRAIN.format(ramp, "4 4 1", "0 0 0").replace("<static>1", "<static>0"), "t", [ramp.parent]
    )
    with pytest.raises(Exception, match="must belong to a static model"):
        build().spawn(model, "t", Pose())
