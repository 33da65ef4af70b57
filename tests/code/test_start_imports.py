"""What a launch waits for loads no library that it does not use: each costs wall time at the start."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest
from python_sources import folder_of

ROOT = Path(__file__).resolve().parents[2]

NUMBA = ("numba", "llvmlite", "scipy")  # a quarter of a second

pytestmark = [
    pytest.mark.ros,
    pytest.mark.skipif(
        importlib.util.find_spec("master_thesis_ros") is None,
        reason="needs the workspace's environment: source devel/setup.bash",
    ),
]


def loaded_by(code: str) -> set[str]:
    """The top-level modules that a new process has loaded after this code."""
    code += "\nimport sys; print(*{name.partition('.')[0] for name in sys.modules})"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60.0)
    assert result.returncode == 0, result.stderr
    return set(result.stdout.split())


@pytest.mark.parametrize(
    ("imports", "unused"),
    [
        ("from flights_ros.launch import request", (*NUMBA, "rospy", "roslaunch", "pybullet")),
        ("from master_thesis_ros.launch import request", (*NUMBA, "rospy", "roslaunch", "pybullet")),
        ("from simulation_tools_ros import launch_check", (*NUMBA, "rospy", "numpy")),
        ("from flights_ros.goal_flight import driver", (*NUMBA, "pybullet", "matplotlib")),
    ],
    ids=["check of a flight", "check of an experiment", "check of a launch", "experiment's node"],
)
def test_what_is_not_used_is_not_loaded(imports, unused):
    assert not loaded_by(imports) & set(unused)


def test_a_replay_without_clouds_loads_none_of_scipys_parts():
    code = "import gridslam_ros.replay, gridslam.loop_closure.closer, gridslam.loop_closure.warm_up, sys"
    unused = {"scipy.sparse", "scipy.spatial", "scipy.ndimage"}
    loaded_by(f"{code}\nassert not {unused!r} & {{*sys.modules}}")


LIGHT_NODES = (
    "simulation_tools/mavros",
    "simulation_tools/mavros_publisher",
    "simulation_tools/tf_publisher",
    "inspection_tools/position_controller",
    "inspection_tools/lidar_median_filter",
    "inspection_tools/lidar_padding",
    "inspection_tools/yaw_regulator",
)
"""The nodes of Experiment 1 that run no kernel. They start beside the simulator, on the same cores."""
IMPORT = """
from importlib.machinery import SourceFileLoader
import sys
sys.dont_write_bytecode = True  # no cache among the executables
SourceFileLoader("node", {path!r}).load_module()
"""


@pytest.mark.parametrize("node", LIGHT_NODES)
def test_a_node_without_kernels_loads_neither_numba_nor_physics(node):
    package, name = node.split("/")
    path = str(folder_of(package) / "nodes" / name)
    assert not loaded_by(IMPORT.format(path=path)) & {*NUMBA, "pybullet", "embreex", "matplotlib"}


def test_a_kernel_without_a_product_of_matrices_loads_no_scipy_linalg(tmp_path):
    (tmp_path / "kernels.py").write_text(
        "from kernel_cache.compiler import njit\n"
        "@njit(cache=False)\ndef double(x):\n    return 2.0 * x\n"
        "@njit(cache=False)\ndef product(a, b):\n    return a @ b\n"
    )
    code = f"""
import sys; sys.path.insert(0, {str(tmp_path)!r})
import kernels, numpy
assert kernels.double(2.0) == 4.0
assert "scipy.linalg" not in sys.modules
found = kernels.product(numpy.array([[0.0, 1.0], [2.0, 3.0]]), numpy.array([[1.0, 0.0], [1.0, 1.0]]))
assert found.tolist() == [[1.0, 1.0], [5.0, 3.0]]
"""
    loaded_by(code)
