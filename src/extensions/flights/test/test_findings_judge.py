"""Given a wall with known defects and findings placed by hand, each is counted as what it is."""

import numpy as np
import pytest

from flights.inspecting.findings_judge import disturbed, judge_findings
from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.findings.merging import Finding
from inspection.survey.parameters import SurveyParameters
from inspection.survey.surface.mesh_file import Mesh
from inspection.survey.surface.patches import grouped
from inspection.survey.surface.samples import SurfacePoints
from simulation_tools.camera.defects import Defect

CAMERA, ASKED = SurveyCamera(800, 600, 60.0), SurveyParameters(resolution=1.2)
PLACE_M = (-0.7, 0.0, 0.0)  # 1.01 mm per pixel, 0.81 by 0.61 m of the wall x = 0
TAKEN = [PhotographPose(np.array(PLACE_M), optical_axes(0.0, 0.0))]
CORNERS_M = np.array([(0.0, -2.0, -2.0), (0.0, 2.0, -2.0), (0.0, 2.0, 2.0), (0.0, -2.0, 2.0)])
WALL = Mesh(CORNERS_M[[[0, 1, 2], [0, 2, 3]]], ("wall",), np.zeros(2, int))


def patches():
    y, z = np.meshgrid(np.arange(-1.95, 2.0, 0.1), np.arange(-1.95, 2.0, 0.1))
    points = np.column_stack((np.zeros(y.size), y.ravel(), z.ravel()))
    normals = np.tile((-1.0, 0.0, 0.0), (y.size, 1))
    return grouped(
        SurfacePoints(points, normals, np.full(y.size, 0.01), np.zeros(y.size, int)), ("wall",), 0.1
    )


def defect(kind, y_m, z_m, width_m=0.001, length_m=0.3):
    return Defect(kind, (0.0, y_m, z_m), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), length_m, width_m)


def finding(number, kind, y_m, z_m):
    return Finding(number, kind, (0.0, y_m, z_m), (-1.0, 0.0, 0.0), 0.1, 0.0, ("a.jpg",))


def judged(findings, defects):
    return judge_findings(findings, defects, TAKEN, CAMERA, ASKED, WALL, patches())


def test_what_is_found_missed_false_and_not_photographed():
    defects = [
        defect("crack", 0.0, 0.0),
        defect("crack", 0.2, 0.0, width_m=0.0005),
        defect("crack", 1.5, 0.0),  # beside the photograph
        defect("rust", -0.2, 0.0, width_m=0.1, length_m=0.1),
        defect("stain", -0.2, 0.2),
    ]
    findings = [
        finding(1, "crack", 0.02, 0.12),  # 0.02 m beside the line, whose half is 0.15 m
        finding(2, "crack", -0.2, 0.2),  # a stain is no crack
        finding(3, "rust", -0.2, 0.05),
        finding(4, "crack", 1.5, 0.1),
    ]
    told = judged(findings, defects)
    assert (told.rust.shown, told.rust.found) == (1, 1)
    assert (told.cracks.shown, told.cracks.found) == (2, 1)
    assert (told.wide_cracks.shown, told.wide_cracks.found) == (1, 1)
    assert [each.id for each in told.false] == [2]
    assert sorted(told.off_m) == pytest.approx([0.0, 0.02, 0.05])
    assert told.area_m2 == pytest.approx(0.81 * 0.61, abs=0.1)
    assert told.false_per_100_m2 == pytest.approx(100.0 / told.area_m2)


def test_a_defect_that_is_hidden_or_seen_too_flat_is_not_photographed():
    flat = Defect("crack", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), 0.3, 0.001)
    behind = Defect("crack", (0.1, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.3, 0.001)
    told = judged([], [flat, behind])
    assert (told.cracks.shown, told.cracks.share) == (0, None)


def test_disturbed_poses_are_off_by_the_medians_asked():
    rng = np.random.default_rng(3)
    poses = [disturbed(TAKEN[0], rng, 0.006, 0.33) for _ in range(2000)]
    off_m = [np.linalg.norm(each.place_m - PLACE_M) for each in poses]
    turned = [(np.trace(each.axes @ TAKEN[0].axes.T) - 1.0) / 2.0 for each in poses]
    assert np.median(off_m) == pytest.approx(0.006, rel=0.05)
    assert np.degrees(np.median(np.arccos(turned))) == pytest.approx(0.33, rel=0.05)
