"""The results folder: never overwritten, files complete or absent, sentences instead of tracebacks."""

import csv
import json
import math
import os
import resource
import signal
import subprocess
from datetime import datetime

import numpy as np
import pytest

from flights.errors import ResultsError
from flights.flight.bag_recorder import shortage_of
from flights.results import run_folder as results
from flights.results import run_summary
from flights.results.run_folder import RunFolder
from flights.results.sources import commit

NOON = datetime(2026, 11, 20, 12, 0, 0)


@pytest.fixture
def folder(tmp_path):
    return RunFolder(tmp_path, "experiment_1", NOON)


def test_a_folder_is_named_by_its_time_and_never_taken_twice(tmp_path):
    names = [RunFolder(tmp_path, "experiment_1", NOON).path.relative_to(tmp_path) for _ in range(3)]
    stem = "experiment_1/2026-11-20_12-00-00"
    assert [str(name) for name in names] == [stem, f"{stem}_1", f"{stem}_2"]


def test_json_is_what_was_given_with_null_for_what_json_cannot_say(folder):
    content = {
        "a": np.float64(1.5),
        "b": (1, np.int64(2)),
        "c": math.nan,
        "d": {"e": -math.inf},
        "f": np.bool_(True),
    }
    path = folder.write_json("result.json", content)
    assert json.loads(path.read_text()) == {"a": 1.5, "b": [1, 2], "c": None, "d": {"e": None}, "f": True}


def test_csv_holds_what_was_given(folder):
    path = folder.write_csv("series.csv", ("t_s", "what"), [(0.1, "a,b"), (1 / 3, 'say "c"')])
    rows = list(csv.reader(path.open()))
    assert rows[0] == ["t_s", "what"]
    assert rows[1:] == [["0.1", "a,b"], ["0.333333333", 'say "c"']]


def test_a_file_that_cannot_be_completed_leaves_the_old_one_and_no_rest(folder):
    # Given a complete file, and a limit on file sizes that stands for a full disk
    folder.write_json("result.json", {"old": 1})
    was = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, was[1]))
    # When a longer file is written
    try:
        with pytest.raises(
            ResultsError, match=r"Cannot write .*result\.json: File too large; free some space or"
        ):
            folder.write_json("result.json", {"new": "x" * 5000})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, was)
        signal.signal(signal.SIGXFSZ, handler)
    # Then the old one is there, whole, and nothing else
    assert json.loads((folder.path / "result.json").read_text()) == {"old": 1}
    assert os.listdir(folder.path) == ["result.json"]


def test_a_folder_that_cannot_be_made_gives_a_sentence(tmp_path):
    (tmp_path / "experiment_1").write_text("a file in the way")
    with pytest.raises(
        ResultsError, match=r"Cannot make a results folder in .*; .*choose another folder with results:="
    ):
        RunFolder(tmp_path, "experiment_1", NOON)


def test_the_commit_is_git_s(tmp_path):
    git = ["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@example.org"]
    assert commit(tmp_path).startswith("no-git.")
    subprocess.run([*git, "init", "-q"], check=True)
    (tmp_path / "file").write_text("1")
    subprocess.run([*git, "add", "file"], check=True)
    subprocess.run([*git, "commit", "-q", "-m", "one"], check=True)
    revision = subprocess.check_output([*git, "rev-parse", "HEAD"], text=True).strip()
    assert commit(tmp_path) == revision
    (tmp_path / "file").write_text("2")
    edited = commit(tmp_path)
    assert edited.startswith(f"{revision}+changes.")
    assert commit(tmp_path) == edited
    (tmp_path / "file").write_text("3")
    assert commit(tmp_path).startswith(f"{revision}+changes.")
    assert commit(tmp_path) != edited


def test_without_git_every_edit_of_the_code_is_another_version(tmp_path):
    code = tmp_path / "src/package/src/package"
    code.mkdir(parents=True)
    (tmp_path / ".catkin_workspace").touch()
    (code / "one.py").write_text("1")
    versions = [commit(code)]
    (tmp_path / "results").mkdir()
    (tmp_path / "results/result.json").write_text("{}")
    (code / "__pycache__").mkdir()
    (code / "__pycache__/one.pyc").write_text("1")
    assert [commit(code)] == versions, "a result is no code"
    for path, text in (
        (code / "one.py", "2"),
        (code / "two.py", "2"),
        (tmp_path / "src/package/a.yaml", "3"),
    ):
        path.write_text(text)
        versions.append(commit(code))
    (code / "two.py").rename(code / "three.py")
    versions.append(commit(code))
    assert len(set(versions)) == 5


def test_machine_and_versions_are_told():
    assert results.machine()["cores"] == os.cpu_count()
    assert results.versions()["numpy"] == np.__version__


@pytest.mark.table(("free_mb", "wrong"), [(199.9, True), (200.0, False), (0.0, True)])
def test_a_disk_too_full_to_record_is_told_of(tmp_path, free_mb, wrong):
    sentence = shortage_of(tmp_path / "flight.bag", free_mb)
    assert (sentence is not None) is wrong
    if wrong:
        assert f"Only {free_mb:.0f} MB are free for {tmp_path}/flight.bag" in sentence
        assert sentence.endswith("choose another folder with results:=.")


# -- a flight that repeats -----------------------------------------------------------------------------------

SHA256_OF_ABC = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
"""FIPS 180-4's example."""


@pytest.mark.table(
    ("lockstep", "misses", "digest"), [(True, 0, SHA256_OF_ABC), (True, 1, None), (False, 0, None)]
)
def test_a_flight_that_repeats_has_a_digest(tmp_path, lockstep, misses, digest):
    (tmp_path / "truth.csv").write_text("abc")
    content = {"parameters": {"gazebo": {"lockstep": lockstep}}, "lockstep_misses": misses}
    assert run_summary.truth_digest(tmp_path, content) == digest


def test_a_run_without_a_flight_has_no_digest(tmp_path):
    content = {"parameters": {"gazebo": {"lockstep": True}}, "lockstep_misses": 0}
    assert run_summary.truth_digest(tmp_path, content) is None
    assert run_summary.truth_digest(tmp_path, {"parameters": None}) is None
