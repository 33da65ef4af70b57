"""The set-up refuses a shell whose PYTHONPATH would give nodes other packages than .venv's."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = """
set -euo pipefail
root=$PWD log_file=/dev/null
source scripts/console.sh
source scripts/setup.sh
check_python_path
echo "goes on"
"""


def check(python_path):
    environment = {"PATH": "/usr/bin:/bin", **({} if python_path is None else {"PYTHONPATH": python_path})}
    return subprocess.run(
        ["bash", "-c", SCRIPT], cwd=ROOT, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("python_path", [None, "", "{0}", "/opt/ros/lib:{0}:"])
def test_a_shell_that_shadows_nothing_goes_on(python_path, tmp_path):
    (tmp_path / "rospy").mkdir()
    done = check(python_path and python_path.format(tmp_path))
    assert (done.returncode, done.stdout) == (0, "goes on\n")


@pytest.mark.parametrize("name", ["numpy", "tqdm.py"])
def test_a_folder_with_packages_of_the_workspace_is_named(name, tmp_path):
    (tmp_path / name).mkdir() if "." not in name else (tmp_path / name).touch()
    done = check(f"/opt/ros/lib:{tmp_path}")
    assert done.returncode == 1
    assert f"PYTHONPATH names {tmp_path}, which holds another {Path(name).stem} than .venv" in done.stderr
    assert "env -u PYTHONPATH" in done.stderr
