"""The set-up deletes parts of packages; what is left, all tests import."""

from __future__ import annotations

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = """
set -euo pipefail
cd "$root"
log_file=/dev/null
source "$repository/scripts/console.sh"
source "$repository/scripts/setup.sh"
slim_python
"""


def test_tests_go_but_those_that_numpy_imports(tmp_path):
    packages = tmp_path / "packages"
    deleted = ["numpy/lib/tests", "scipy/spatial/tests", "pandas/tests", "numba/tests", "matplotlib/tests"]
    kept = ["numpy/_core/tests", "numpy/testing", "pymavlink/dialects/v20"]
    for name in (*deleted, *kept):
        (packages / name).mkdir(parents=True)
        (packages / name / "__init__.py").touch()
    interpreter = tmp_path / ".venv/bin/python"
    interpreter.parent.mkdir(parents=True)
    interpreter.write_text(f"#!/bin/sh\necho {packages}\n")
    interpreter.chmod(0o755)
    environment = {"PATH": "/usr/bin:/bin", "root": str(tmp_path), "repository": str(ROOT)}
    subprocess.run(["bash", "-c", SCRIPT], env=environment, check=True)
    assert not [name for name in deleted if (packages / name).exists()]
    assert all((packages / name / "__init__.py").exists() for name in kept)
