"""Every rostest of the workspace, as one pytest test each.

A rostest brings its own master on a free port, so that several can run at a time.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROSTESTS = sorted(ROOT.glob("src/**/test/**/*.test"))
TIMEOUT_S = 600.0

pytestmark = [pytest.mark.ros, pytest.mark.timeout(TIMEOUT_S + 30.0)]


def name_of(path: Path) -> str:
    return f"{path.parts[path.parts.index('test', len(ROOT.parts)) - 1]}/{path.stem}"


def with_marks(path: Path):
    """Return the parameter of a rostest; a launch file that says so is long as a whole."""
    marks = [pytest.mark.long] if "<!-- long -->" in path.read_text() else []
    return pytest.param(path, id=name_of(path), marks=marks)


@pytest.mark.parametrize("path", [with_marks(path) for path in ROSTESTS])
def test_rostest(path, processes, tmp_path, pytestconfig):
    if not pytestconfig.option.all:
        processes.environment["WITHOUT_LONG_TESTS"] = "yes"  # see `node_tools.testing`
    try:
        run = processes.run("rostest", "--results-base-dir", str(tmp_path), str(path), timeout_s=TIMEOUT_S)
    except subprocess.TimeoutExpired as error:
        pytest.fail(f"{path.name} did not end within {TIMEOUT_S:g} s:\n{error.output}", pytrace=False)
    # rostest counts a test that ended without results as passed: a node that it needs may have died
    results = [cases_in(file) for file in tmp_path.rglob("rosunit-*.xml")]
    cases = [case for file in tmp_path.rglob("*.xml") for case in cases_in(file)]
    if run.returncode != 0 or not all(results) or not results:
        failures = [failure.text or "" for case in cases for kind in FAILED for failure in case.iter(kind)]
        told = "\n".join([run.stdout, said_by_nodes(tmp_path / "ros/log"), *failures])
        pytest.fail(
            f"{path.name}: code {run.returncode}, {sum(map(len, results))} results\n{told}", pytrace=False
        )


FAILED = ("failure", "error")


def cases_in(results: Path) -> list[ElementTree.Element]:
    """Return the cases of a result file; none if it holds no more than its first line."""
    try:
        return list(ElementTree.parse(results).iter("testcase"))
    except ElementTree.ParseError:
        return []


def said_by_nodes(logs: Path) -> str:
    """Return the end of what each process printed, which rostest keeps to itself."""
    ends = (log.read_text(errors="replace").splitlines()[-20:] for log in sorted(logs.rglob("*.log")))
    return "\n".join(line for end in ends for line in end if "] " in line or "Error" in line)
