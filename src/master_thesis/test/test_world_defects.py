"""Given a hold, the defects lie on its surfaces, and the shipped files are those of the generator."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from inspection_tools.photographs.folder import read_photograph
from inspection_tools.survey.camera import SurveyCamera
from master_thesis.errors import ScenarioError
from master_thesis.photographing.command import photograph, read_poses
from master_thesis.worlds.defects import NUMBERS, write_defects
from simulation_tools.camera.defects import beside, decals_of, read_defects
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.sdf.parser import load_world

WORLDS = Path(__file__).resolve().parents[1] / "worlds"


@pytest.mark.parametrize("name", ["hold_3d", "ballast_tank"])
def test_the_shipped_file_is_the_generators(name, tmp_path):
    world = WORLDS / f"{name}.world"
    written = write_defects(world, tmp_path / "d.yaml", seed=1)
    assert written.read_text() == beside(world).read_text()
    marks = read_defects(written)
    assert Counter(defect.kind for defect in marks.defects) == NUMBERS
    surfaces = surfaces_of(load_world(str(world)))
    assert (decals_of(marks.defects, surfaces).first[-1]) >= len(marks.defects)  # each lies on a face
    for defect in marks.defects:
        assert defect.kind != "rust" or 0.03 <= defect.length_m <= 0.30
        assert defect.kind != "crack" or (0.2 <= defect.length_m <= 1.0 and 0.0003 <= defect.width_m <= 0.002)


def test_a_plan_is_photographed(tmp_path):
    plan = tmp_path / "plan.yaml"
    plan.write_text("photographs: [{position_m: [4, 5.5, 4], yaw_deg: 90, tilt_deg: 0}]")
    paths = list(photograph(WORLDS / "hold_3d.world", read_poses(plan), tmp_path, SurveyCamera(64, 48), 1))
    picture, record = read_photograph(paths[0])
    assert picture.shape == (48, 64, 3)
    assert record.position_m == (4.0, 5.5, 4.0)
    # Towards port (+y): the optical axis, z of the optical frame.
    x, y, z, w = record.orientation_xyzw
    axis = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
    assert np.allclose(axis, (0.0, 1.0, 0.0))


@pytest.mark.parametrize("text", ["[]", "photographs: [{yaw_deg: 1}]", "photographs: [3]", "{"])
def test_a_bad_plan_is_refused(tmp_path, text):
    (tmp_path / "plan.yaml").write_text(text)
    with pytest.raises(ScenarioError, match=r"plan\.yaml"):
        read_poses(tmp_path / "plan.yaml")
