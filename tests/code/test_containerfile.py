"""The container is built upon the releases that are tested, from what a clone has, by the set-up itself."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
STEPS = [
    line for line in (ROOT / "Containerfile").read_text(encoding="utf-8").splitlines() if line[:1].isupper()
]


def test_it_stands_upon_a_tested_release():
    (release,) = [line.split("=")[1] for line in STEPS if line.startswith("ARG RELEASE=")]
    assert (ROOT / f"scripts/packages/debian-{release}.txt").exists()
    assert [line for line in STEPS if line.startswith("FROM")] == ["FROM docker.io/library/debian:${RELEASE}"]


def test_it_has_nothing_but_a_clone_and_calls_the_commands_of_the_readme():
    """A bare system has git and certificates to clone with. All else is the set-up's own work."""
    runs = [line.removeprefix("RUN ") for line in STEPS if line.startswith("RUN")]
    (installed,) = re.findall(r"apt-get install -y --no-install-recommends (.*)", runs[0])
    assert installed.split() == ["ca-certificates", "git"]
    assert runs[1:] == ["./bringup.sh setup"]
    assert STEPS[-1] == 'CMD ["./bringup.sh"]'


def test_what_the_set_up_makes_here_stays_outside():
    left_out = (ROOT / ".dockerignore").read_text().split()
    assert {".venv", "build", "devel", "logs", "results"} <= set(left_out)
