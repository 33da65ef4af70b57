"""Python blocks of the pages run, with values for the names that the page leaves to its reader."""

from __future__ import annotations

import pytest
from snippets import ROOT, fenced, pages

pytestmark = pytest.mark.ros

GIVEN = """
import math
import numpy as np
ranges = np.full(1081, 4.0)
angle_min, angle_increment, range_min, range_max = -math.radians(135), math.radians(0.25), 0.06, 10.0
"""
POSE = """
x, y, yaw, roll, pitch, height, stamp = 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 1.0
lidar_in_base = ((0.0, 0.0, 0.1), (0.0, 0.0, 0.0, 1.0))
"""
ROOM = """
import numpy as np
tiles, voxels = np.argwhere(np.ones((2, 2, 2))), np.ones((8, 4096), np.uint8)
start_m, goal_m = np.array((1.2, 1.5, 1.5)), np.array((1.8, 1.5, 1.5))
"""
PLATE = """
from pathlib import Path
Path("plate.obj").write_text("v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nf 1 2 3\\n")
"""
PYTHON = {
    "src/helpers/stamp_pairing/README.md": ("", "paired.fresh('reference', 500_000_000, None) == (1.5, 0.0)"),
    "src/helpers/flight_limits/README.md": (
        "",
        "limits.ceiling_m == 8.0 and limits.boxes[0].holds((12, 0, 7))",
    ),
    "src/helpers/mesh_files/README.md": (PLATE, "len(parts[0].triangles) == 1"),
    "src/cepa/README.md": (GIVEN, "decision.velocity_xy != (0.0, 0.0)"),
    "src/gridslam/README.md": (GIVEN + POSE, "update is not None"),
    "src/inspection_tools/README.md": (
        GIVEN + "stamp_s, position_m, yaw_rad = 1.0, (0.0, 0.0, 2.0), 0.0\n",
        "yaw_rate > 0.0 and not command.goal_reached",
    ),
    "src/extensions/exploration/doc/path_planner.md": (ROOM, "abs(plan.length_m - 0.6) < 1e-9"),
    "src/simulation_tools/README.md": (
        "",
        "abs(simulation.world.get_state('iris').pose.position_m[2] - 2.0) < 0.3 and not simulation.close()",
    ),
}
"""By page: what its reader has before the page's python, and what is true afterwards."""
SKELETONS = {
    "src/gridslam/doc/loop_closure.md": "lines of a caller's loop; test_loop_closure.py runs the same calls",
    "src/extensions/inspection/doc/findings.md": "a node; rostest_detector.py runs it on photographs",
    "src/helpers/kernel_cache/README.md": "a kernel; test_compiler.py compiles others",
    "src/helpers/node_tools/README.md": "the frame of a node, with dots where its imports stand",
    "src/extensions/flights/doc/tutorial.md": "a node; test_tutorial.py runs it against a scan",
}


def test_a_python_snippet_has_a_place_here():
    of_python = {page for page in pages() if fenced(page, "python")}
    assert of_python == PYTHON.keys() | SKELETONS.keys()


@pytest.mark.parametrize("page", PYTHON)
def test_a_python_snippet_runs(page, monkeypatch, tmp_path):
    monkeypatch.chdir((ROOT / page).parent)
    (block,) = fenced(page, "python")
    given, afterwards = PYTHON[page]
    mission = tmp_path / "mission.yaml"
    mission.write_text(fenced("src/inspection_tools/doc/reference.md", "yaml")[0])
    names: dict = {}
    text = given + block
    for name in ("mission.yaml", "plate.obj"):
        text = text.replace(f'"{name}"', repr(str(tmp_path / name)))
    exec(text, names)
    assert eval(afterwards, names)


@pytest.mark.parametrize("page", SKELETONS)
def test_a_python_skeleton_is_python(page):
    for block in fenced(page, "python"):
        compile(block, page, "exec")
