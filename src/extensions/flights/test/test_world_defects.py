"""Given a hold, the defects lie on its surfaces, and the shipped files are those of the generator."""

import runpy
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import yaml

from flights.photographing.command import photograph, poses_of
from flights.worlds import floor_plan
from flights.worlds.ballast_tank import BallastTankParameters
from flights.worlds.cargo import NAMES as NAMES_OF_CARGO
from flights.worlds.defects import NUMBERS, write_defects
from inspection.photographs.listing import read_photograph
from inspection.survey.plan_file import read_plan
from simulation_tools.camera.defects import beside, decals_of, defects_in, read_defects
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.sdf.parser import load_world

WORLDS = Path(__file__).resolve().parents[1] / "worlds"


def leaves(value):
    """Yield all keys and values of what YAML gives."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield key
            yield from leaves(item)
    elif isinstance(value, list):
        for item in value:
            yield from leaves(item)
    else:
        yield value


@pytest.mark.table("name", ["hold_3d", "hold_3d_cargo", "ballast_tank"])
def test_the_shipped_file_is_the_generators(name, tmp_path):
    world = WORLDS / f"{name}.world"
    written = tmp_path / "d.yaml"
    assert write_defects(world, written, seed=1) == {}
    ours, shipped = (list(leaves(yaml.safe_load(file.read_text()))) for file in (written, beside(world)))
    assert [each for each in ours if type(each) is not float] == [
        each for each in shipped if type(each) is not float
    ]
    # Embree's last digit depends on the processor
    assert [each for each in ours if type(each) is float] == pytest.approx(
        [each for each in shipped if type(each) is float], abs=2e-5
    )
    marks = read_defects(written)
    assert Counter(defect.kind for defect in marks.defects) == NUMBERS
    surfaces = surfaces_of(load_world(str(world)))
    assert (decals_of(marks.defects, surfaces).first[-1]) >= len(marks.defects)  # each lies on a face
    for defect in marks.defects:
        assert defect.kind != "rust" or 0.03 <= defect.length_m <= 0.30
        assert defect.kind != "crack" or (0.2 <= defect.length_m <= 1.0 and 0.0003 <= defect.width_m <= 0.002)


def tank(size_m):
    """A closed tank of plates, x, y, z in m, whose bottom's middle is the origin."""
    (x, y, z), t = size_m, 0.02
    plates = [((0, 0, h), (x, y, t)) for h in (-t / 2, z + t / 2)]
    plates += [((side * (x + t) / 2, 0, z / 2), (t, y, z)) for side in (-1, 1)]
    plates += [((0, side * (y + t) / 2, z / 2), (x, t, z)) for side in (-1, 1)]
    models = ""
    for number, (at, size) in enumerate(plates):
        shape = f"<geometry><box><size>{size[0]} {size[1]} {size[2]}</size></box></geometry>"
        models += (
            f'<model name="plate_{number}"><static>true</static><pose>{at[0]} {at[1]} {at[2]} 0 0 0</pose>'
            f'<link name="link"><collision name="c">{shape}</collision>'
            f'<visual name="v">{shape}</visual></link></model>'
        )
    return f'<sdf version="1.6"><world name="tank">{models}</world></sdf>'


@pytest.mark.long
def test_a_small_tank_gets_smaller_marks(tmp_path):
    """No seam of 2.3 m fits on plates of 1.6 x 1.2 x 1.6 m."""
    world = tmp_path / "tank.world"
    world.write_text(tank((1.6, 1.2, 1.6)))
    left_out = write_defects(world, tmp_path / "d.yaml", seed=3, share=0.1)
    marks = Counter(mark.kind for mark in read_defects(tmp_path / "d.yaml").defects)
    assert marks + Counter(left_out) == Counter({kind: n // 10 for kind, n in NUMBERS.items()})
    assert marks["rust"] == 6
    seams = [mark.length_m for mark in read_defects(tmp_path / "d.yaml").defects if mark.kind == "seam"]
    assert len(seams) == 4
    assert max(seams) <= 1.6


def test_the_repositorys_own_world_gets_marks_on_what_stands_in_it(tmp_path):
    """It is open: marks lie on wall, crate and the flat tops of what is round, not on the ground."""
    world = WORLDS.parents[3] / "my.world"
    write_defects(world, tmp_path / "d.yaml", seed=1, share=0.1)
    marks = read_defects(tmp_path / "d.yaml").defects
    assert Counter(mark.kind for mark in marks)["rust"] == 6
    assert all(mark.position_m[2] > 0.02 and 3.7 < mark.position_m[1] < 17.4 for mark in marks)


def test_a_world_without_a_file_of_defects_is_told_with_the_command_that_writes_one(tmp_path):
    marks, remark = defects_in(tmp_path / "mine.world", None)
    assert marks.defects == ()
    assert "mine.world has no defects" in remark
    assert f"make_defects {tmp_path}/mine.world" in remark
    assert defects_in(WORLDS / "hold_3d.world", None)[1] == ""


def test_a_folder_that_is_not_there_is_told_before_places_are_looked_for(tmp_path, monkeypatch, capsys):
    main = runpy.run_path(str(WORLDS.parent / "nodes/make_defects"))["main"]
    words = [str(WORLDS / "hold_3d.world"), "--out", str(tmp_path / "none/x.yaml")]
    monkeypatch.setattr(sys, "argv", ["make_defects", *words])
    monkeypatch.setitem(main.__globals__, "write_defects", lambda *_: pytest.fail("it looked for places"))
    assert main() == 1
    assert f"there is no folder {tmp_path}/none" in capsys.readouterr().err


def test_each_compartment_of_the_tank_has_defects():
    tank = BallastTankParameters()
    marks = read_defects(WORLDS / "ballast_tank.defects.yaml").defects
    x_m = [mark.position_m[0] for mark in marks if mark.kind in ("rust", "crack")]
    least = len(x_m) / tank.compartments / 2
    assert (np.bincount(np.digitize(x_m, tank.bulkheads_x_m)) > least).all()


def test_no_defect_is_on_cargo():
    world = load_world(str(WORLDS / "hold_3d_cargo.world"))
    boxes = [each for each in floor_plan.outlines(world) if each.name.split("::")[0] in NAMES_OF_CARGO]
    for defect in read_defects(WORLDS / "hold_3d_cargo.defects.yaml").defects:
        for each in boxes:
            low, high = each.outline_xy.min(axis=0) - 0.01, each.outline_xy.max(axis=0) + 0.01
            beside = (np.array(defect.position_m[:2]) < low).any() or (
                np.array(defect.position_m[:2]) > high
            ).any()
            turned = each.name.startswith(("stray_container", "crates"))  # their boxes hold free floor, too
            on_floor = defect.position_m[2] < 0.01
            assert beside or defect.position_m[2] > each.top_m + 0.01 or (turned and on_floor)


PLAN = """home: [0, 0, 1]
camera: {width: 64, height: 48}
flights: [{photographs: [{at: [4, 5.5, 4], yaw: 90, tilt: 0}]}]
"""


def test_a_plan_is_photographed_and_the_folder_continued(tmp_path):
    (tmp_path / "plan.yaml").write_text(PLAN)
    plan, world = read_plan(tmp_path / "plan.yaml"), WORLDS / "hold_3d.world"
    for run in range(2):
        (path,) = photograph(world, poses_of(plan), tmp_path / "shots", plan.camera, 1)
        picture, record = read_photograph(path)
        assert (path.name, record.stamp_s) == (f"{run}.000000.jpg", run)
    assert len((tmp_path / "shots" / "rgb.txt").read_text().splitlines()) == 1 + 2
    assert picture.shape == (48, 64, 3)
    assert record.position_m == (4.0, 5.5, 4.0)
    # Towards port (+y): the optical axis, z of the optical frame.
    x, y, z, w = record.orientation_xyzw
    axis = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
    assert np.allclose(axis, (0.0, 1.0, 0.0))
