"""What a launch waits for loads no library that it does not use: each costs wall time at the start."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys

import pytest
from python_sources import folder_of

NUMBA = ("numba", "llvmlite", "scipy")  # a quarter of a second

pytestmark = [
    pytest.mark.ros,
    pytest.mark.skipif(
        importlib.util.find_spec("master_thesis_ros") is None,
        reason="needs the workspace's environment: source devel/setup.bash",
    ),
]

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
NODE = 'SourceFileLoader("node", {path!r}).load_module()'
STEPS = {
    "check of a launch": (
        "from simulation_tools_ros import launch_check",
        (*NUMBA, "rospy", "numpy"),
    ),
    "check of a flight": (
        "from flights_ros.launch import request; from master_thesis_ros.launch import request",
        (*NUMBA, "rospy", "roslaunch", "pybullet"),
    ),
    "experiment's node": (
        "from flights_ros.goal_flight import driver",
        (*NUMBA, "pybullet", "matplotlib"),
    ),
    "nodes without kernels": (
        "; ".join(
            NODE.format(path=str(folder_of(package) / "nodes" / name))
            for package, name in (node.split("/") for node in LIGHT_NODES)
        ),
        (*NUMBA, "pybullet", "embreex", "matplotlib"),
    ),
    "replay without clouds": (
        "import gridslam_ros.replay, gridslam.loop_closure.closer, gridslam.loop_closure.warm_up",
        ("scipy.sparse", "scipy.spatial", "scipy.ndimage"),
    ),
    "kernel without a product of matrices": (
        "import kernels; assert kernels.double(2.0) == 4.0",
        ("scipy.linalg",),
    ),
}
"""What is imported, one after the other in one process, and what must not be loaded then."""
KERNELS = """
from kernel_cache.compiler import njit
@njit(cache=False)
def double(x):
    return 2.0 * x
@njit(cache=False)
def product(a, b):
    return a @ b
"""
AT_LAST = """
found = kernels.product(numpy.array([[0.0, 1.0], [2.0, 3.0]]), numpy.array([[1.0, 0.0], [1.0, 1.0]]))
assert found.tolist() == [[1.0, 1.0], [5.0, 3.0]]
"""


@pytest.fixture(scope="module")
def loaded(tmp_path_factory) -> dict[str, set[str]]:
    """The modules that a new process has loaded after each step."""
    folder = tmp_path_factory.mktemp("kernels")
    (folder / "kernels.py").write_text(KERNELS)
    lines = [
        "import json, sys",
        "from importlib.machinery import SourceFileLoader",
        "sys.dont_write_bytecode = True  # no cache among the executables",
        f"sys.path.insert(0, {str(folder)!r})",
    ]
    for imports, _ in STEPS.values():
        lines += [imports, "print(json.dumps([*sys.modules]))"]
    code = "\n".join((*lines, "import numpy", AT_LAST))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120.0)
    assert done.returncode == 0, done.stderr
    return {step: {*json.loads(line)} for step, line in zip(STEPS, done.stdout.splitlines(), strict=True)}


@pytest.mark.parametrize("step", STEPS)
def test_what_is_not_used_is_not_loaded(loaded, step):
    assert not loaded[step] & {*STEPS[step][1]}
