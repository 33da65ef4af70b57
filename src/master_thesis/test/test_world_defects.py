"""Given a hold, the defects lie on its surfaces, and the shipped files are those of the generator."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import yaml

from inspection_tools.photographs.listing import read_photograph
from inspection_tools.survey.plan_file import read_plan
from master_thesis.photographing.command import photograph, poses_of
from master_thesis.worlds import floor_plan
from master_thesis.worlds.ballast_tank import BallastTankParameters
from master_thesis.worlds.cargo import NAMES as NAMES_OF_CARGO
from master_thesis.worlds.defects import NUMBERS, write_defects
from simulation_tools.camera.defects import beside, decals_of, read_defects
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


@pytest.mark.parametrize("name", ["hold_3d", "hold_3d_cargo", "ballast_tank"])
def test_the_shipped_file_is_the_generators(name, tmp_path):
    world = WORLDS / f"{name}.world"
    written = write_defects(world, tmp_path / "d.yaml", seed=1)
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
