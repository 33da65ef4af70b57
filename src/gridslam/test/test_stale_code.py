"""A kernel flies with the code of the kernels that it calls, whatever numba has kept of them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from gridslam.kernels import stale_code

CALLEE = "import numba\n\n@numba.njit(cache=True)\ndef value():\n    return {}\n"
CALLER = """
import numba
from {package}.callee import value

@numba.njit(cache=True)
def ask():
    return value() + 1
"""
GUARD = """
from pathlib import Path
from gridslam.kernels.stale_code import discard_stale_code
discard_stale_code(Path(__file__).parent)
"""


def make_package(folder: Path, guard: str) -> Path:
    package = folder / "loops"
    package.mkdir()
    (package / "__init__.py").write_text(guard)
    (package / "callee.py").write_text(CALLEE.format(10))
    (package / "caller.py").write_text(CALLER.format(package="loops"))
    return package


def ask(package: Path) -> int:
    """What a process of its own computes."""
    program = "from loops.caller import ask; print(ask())"
    library = Path(stale_code.__file__).resolve().parents[2]
    paths = os.pathsep.join((str(package.parent), str(library)))
    run = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": paths},
        check=True,
        capture_output=True,
        text=True,
    )
    return int(run.stdout)


@pytest.mark.parametrize(("guard", "afterwards"), [(GUARD, 21), ("", 11)], ids=["guarded", "numba alone"])
def test_a_change_in_another_file_counts(tmp_path, guard, afterwards):
    """Numba alone goes on with the old number: that is why the guard is there."""
    package = make_package(tmp_path, guard)
    assert ask(package) == 11
    (package / "callee.py").write_text(CALLEE.format(20))
    assert ask(package) == afterwards


def test_code_is_kept_while_nothing_changes(tmp_path):
    package = make_package(tmp_path, GUARD)
    ask(package)
    kept = {path: path.stat().st_mtime_ns for path in package.glob("__pycache__/*.nb?")}
    assert len(kept) == 4  # an index and one code for each kernel
    ask(package)
    assert {path: path.stat().st_mtime_ns for path in package.glob("__pycache__/*.nb?")} == kept


def test_the_kernels_of_this_package_are_guarded():
    folder = Path(stale_code.__file__).parent
    kept = folder / "__pycache__" / stale_code.DIGEST_FILE
    assert kept.read_text() == stale_code._digest(folder)
