"""A kernel flies with the code of the kernels that it calls, whatever numba has kept of them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from gridslam import stale_code

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
from gridslam.stale_code import discard_stale_code
discard_stale_code(Path(__file__).parent)
"""


def make_package(folder: Path) -> Path:
    package = folder / "loops"
    package.mkdir()
    (package / "__init__.py").write_text(GUARD)
    (package / "callee.py").write_text(CALLEE.format(10))
    (package / "caller.py").write_text(CALLER.format(package="loops"))
    return package


def ask(package: Path) -> int:
    """What a process of its own computes."""
    program = "from loops.caller import ask; print(ask())"
    library = Path(stale_code.__file__).resolve().parents[1]
    paths = os.pathsep.join((str(package.parent), str(library)))
    run = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": paths},
        check=True,
        capture_output=True,
        text=True,
    )
    return int(run.stdout)


def kept(package: Path) -> dict[Path, int]:
    """What numba has kept, and since when."""
    return {path: path.stat().st_mtime_ns for path in package.glob("__pycache__/*.nb?")}


def test_code_is_kept_until_another_file_changes(tmp_path):
    """Without the guard, numba would go on with the old number."""
    package = make_package(tmp_path)
    assert ask(package) == 11
    before = kept(package)
    assert len(before) == 4  # an index and one code for each kernel
    ask(package)
    assert kept(package) == before
    (package / "callee.py").write_text(CALLEE.format(20))
    assert ask(package) == 21


def test_the_kernels_of_this_package_are_guarded():
    folder = Path(stale_code.__file__).parent / "kernels"
    digest = folder / "__pycache__" / stale_code.DIGEST_FILE
    assert digest.read_text() == stale_code._digest(folder)
