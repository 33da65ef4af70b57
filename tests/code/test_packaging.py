"""What catkin installs is what the source tree holds."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

from python_sources import imports, packages, python_nodes

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = packages()


def test_setup_lists_every_python_package():
    for package in PACKAGES:
        (listed,) = (
            node.value
            for node in ast.walk(ast.parse((package / "setup.py").read_text()))
            if isinstance(node, ast.keyword) and node.arg == "packages"
        )
        there = {
            ".".join(path.parent.relative_to(folder).parts)
            for folder in (package / "src", package / "ros")
            for path in folder.glob("**/__init__.py")
        }
        assert set(ast.literal_eval(listed)) == there, package.name


def test_every_node_and_rostest_is_listed():
    for package in PACKAGES:
        listed = set((package / "CMakeLists.txt").read_text().replace("(", " ").replace(")", " ").split())
        launches = [*package.glob("test/**/*.test")]
        # In one process that a launch file starts: see node_tools
        run = {
            file.parent / name
            for file in launches
            for name in re.findall(r"rostest_\w+\.py", file.read_text())
        }
        rostests = {*package.glob("test/**/rostest_*.py")} - run
        there = [*python_nodes(package), *rostests, *launches, *package.glob("cfg/*.cfg")]
        assert not {str(path.relative_to(package)) for path in there} - listed, package.name


def test_catkin_lint_finds_no_error_and_no_warning():
    lint = Path(sys.executable).with_name("catkin_lint")
    done = subprocess.run(
        [lint, "--offline", "-W1", "--strict", ROOT / "src"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    # The real MAVROS brings some of the packages of messages. Then the set-up leaves ours unbuilt.
    packages = [
        manifest
        for manifest in ROOT.glob("src/**/package.xml")
        if not manifest.with_name("CATKIN_IGNORE").exists()
    ]
    assert f"checked {len(packages)} packages" in done.stderr


# -- dependencies ------------------------------------------------------------------------------------------

BY_ROSDEP = {
    "PIL": "python3-pil",
    "hypothesis": "python3-hypothesis",
    "jinja2": "python3-jinja2",
    "lxml": "python3-lxml",
    "matplotlib": "python3-matplotlib",
    "numba": "python3-numba",
    "numpy": "python3-numpy",
    "packaging": "python3-packaging",
    "pandas": "python3-pandas",
    "pytest": "python3-pytest",
    "rospkg": "python3-rospkg",
    "scipy": "python3-scipy",
    "tqdm": "python3-tqdm",
    "yaml": "python3-yaml",
}
"""Python modules and rosdep's names for them."""
BY_REQUIREMENTS = {"cattrs", "dask", "distributed", "embreex", "evo", "optuna", "pybullet"}
BY_REQUIREMENTS |= {"pymavlink", "trimesh"}
"""Python modules that rosdep does not know; requirements.txt has them."""


def test_every_import_is_declared():
    tests = {path: package for package in PACKAGES for path in package.glob("test/**/*.py")}
    foreign = {"benchmarks", *(path.stem for path in tests), *sys.stdlib_module_names, *BY_REQUIREMENTS}
    others = {f"{path.name}_ros": path.name for path in PACKAGES}
    for package in PACKAGES:
        declared = set(re.findall(r"<(?:\w+_)?depend>([^<]+)<", (package / "package.xml").read_text()))
        sources = [*package.glob("src/**/*.py"), *package.glob("ros/**/*.py"), *python_nodes(package)]
        sources += [path for path, owner in tests.items() if owner == package]
        found = set().union(*map(imports, sources)) - foreign - {package.name, f"{package.name}_ros"}
        needed = {BY_ROSDEP.get(name) or others.get(name, name) for name in found}
        assert not needed - declared, f"package.xml of {package.name} lacks {sorted(needed - declared)}"


def test_what_rosdep_does_not_know_is_in_the_requirements():
    lines = (ROOT / "requirements.txt").read_text().lower().splitlines()
    listed = {re.split(r"[^a-z0-9_-]", line)[0] for line in lines if line and line[0].isalpha()}
    assert not {name for name in BY_REQUIREMENTS if name not in listed}
