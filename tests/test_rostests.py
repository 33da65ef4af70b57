"""Every rostest of the workspace, as one pytest test each.

A rostest brings its own master on a free port, so that several can run at a time.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROSTESTS = sorted(ROOT.glob("src/*/test/**/*.test"))
TIMEOUT_S = 240.0

pytestmark = [pytest.mark.ros, pytest.mark.timeout(TIMEOUT_S + 30.0)]


def name_of(path: Path) -> str:
    return f"{path.relative_to(ROOT / 'src').parts[0]}/{path.stem}"


def rostests() -> list:
    return [pytest.param(path, id=name_of(path)) for path in ROSTESTS]


@pytest.mark.parametrize("path", rostests())
def test_rostest(path, processes, tmp_path):
    try:
        run = processes.run("rostest", "--results-base-dir", str(tmp_path), str(path), timeout_s=TIMEOUT_S)
    except subprocess.TimeoutExpired as error:
        pytest.fail(f"{path.name} did not end within {TIMEOUT_S:g} s:\n{error.output}", pytrace=False)
    results = list(tmp_path.rglob("*.xml"))
    if run.returncode != 0:
        details = said_by_nodes(tmp_path / "ros/log") + failures_in(results)
        pytest.fail(f"{path.name} failed with {run.returncode}:\n{run.stdout}\n{details}", pytrace=False)
    ran = sum(len(list(ElementTree.parse(result).iter("testcase"))) for result in results)
    assert ran > 0, f"{path.name} holds no test: {run.stdout}"


def said_by_nodes(logs: Path) -> str:
    """Return the end of what each process printed, which rostest keeps to itself."""
    ends = (log.read_text(errors="replace").splitlines()[-20:] for log in sorted(logs.rglob("*.log")))
    return "\n".join(line for end in ends for line in end if "] " in line or "Error" in line)


def failures_in(results: list[Path]) -> str:
    """Return the failures that rostest's result files tell of."""
    found = (
        failure.text or ""
        for result in results
        for kind in ("failure", "error")
        for failure in ElementTree.parse(result).iter(kind)
    )
    return "\n".join(found)
