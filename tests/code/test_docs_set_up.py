"""`./bringup.sh docs` has an environment of its own, and one sentence where its packages cannot be had."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = """
root=$PWD log_file=$PWD/log
source "$repository/scripts/console.sh"
source "$repository/scripts/setup.sh"
source "$repository/scripts/docs.sh"
detect_platform() { :; }
set_up() { echo "the whole set-up"; }
mkdir -p scripts/packages && echo mkdocs==1 >scripts/packages/docs.txt
"""


def run_docs(folder: Path, *lines: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        ["bash", "-c", "\n".join((SCRIPT, *lines, "run_docs --help"))],
        cwd=folder,
        env={"repository": str(ROOT), "PATH": "/usr/bin:/bin"},
        capture_output=True,
        text=True,
    )


@pytest.mark.parametrize(
    "said",
    [
        "ERROR: Could not find a version that satisfies the requirement mkdocs==1 (from versions: none)",
        "WARNING: Retrying after: Failed to establish a new connection: [Errno 111]",
    ],
)
def test_no_registry_gives_one_sentence(tmp_path, said):
    done = run_docs(tmp_path, f"make_docs_environment() {{ echo '{said}'; return 1; }}")
    assert done.returncode == 1
    sentence, details = done.stderr.splitlines()
    assert "pages can be read without them" in sentence
    assert "No package registry answers" in sentence
    assert details.strip().startswith("Details: ")
    assert "the whole set-up" not in done.stdout


def test_an_environment_that_is_current_is_used(tmp_path):
    python = tmp_path / ".docs/env/bin/python"
    python.parent.mkdir(parents=True)
    python.write_text('#!/bin/sh\necho "called: $*"\n')
    python.chmod(0o755)
    made = "make_docs_environment() { docs_inputs >.docs/.bringup; }"
    assert "installing what builds the handbook" in run_docs(tmp_path, made).stdout
    again = run_docs(tmp_path, "make_docs_environment() { echo again; return 1; }")
    assert again.stdout == "called: -m handbook --help\n"


def test_a_folder_with_other_files_is_not_replaced(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    done = subprocess.run(
        [sys.executable, "-m", "handbook", "--out", tmp_path],
        env={"PYTHONPATH": str(ROOT / "scripts")},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert "holds no handbook" in done.stderr
    assert (tmp_path / "mine.txt").exists()
