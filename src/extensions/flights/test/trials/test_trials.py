"""Trials: each is run once, kept whole, tried again if it failed, and known by the code that ran it."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from flights.errors import FlightError, TrialsError
from flights.files import plain, replace_file
from flights.results.sources import commit
from flights.trials import dask_workers, run
from flights.trials.dask_workers import DaskWorkers
from flights.trials.run import WORKER_DIED, run_trials
from flights.trials.store import Store
from flights.trials.trial import Row, Trial, file_digest, several_versions
from flights.trials.workers import INTERRUPTED, ThisProcess, open_workers
from mesh_files.scratch import scratch_folder

ROOT = Path(__file__).resolve().parents[5]
PATIENCE_S = 60.0


computed: list = []
"""Numbers whose squares this process has computed."""


def square(number, fail=""):
    computed.append(number)
    if fail:
        raise FlightError(fail)
    return {"square": number**2, "third": number / 3, "drawn": b"<svg/>"}


def trial(number=3, inputs=None, **given):
    return Trial(f"square {number}", square, {"number": number, **given}, inputs, title="a square")


def compute(trials, path, workers=None):
    """Run trials in a file; return (rows that there are, failed)."""
    with Store(path) as store:
        failed = run_trials(trials, store, workers or ThisProcess(), "test", quiet=True)
        return [store.get(each) for each in trials], failed


# -- what is kept -------------------------------------------------------------------------------------------


def test_a_trial_is_run_once_for_the_same_inputs(tmp_path):
    computed.clear()
    (first,), _ = compute([trial()], tmp_path / "t.jsonl")
    (again,), _ = compute([trial()], tmp_path / "t.jsonl")
    assert computed == [3]
    assert again == first
    assert first.result == {"square": 9, "third": 1.0, "drawn": "<svg/>"}
    assert first.commit == commit(ROOT)
    assert first.wall_s >= 0.0
    with Store(tmp_path / "t.jsonl") as store:
        assert store.get(trial(inputs={"speed_m_s": 2.0})) is None
    with Store(tmp_path / "t.jsonl", fresh=True) as store:
        assert store.get(trial()) is None


def test_a_trial_that_failed_is_told_of_not_kept_and_tried_again(tmp_path):
    path, trials = (
        tmp_path / "t.jsonl",
        [trial(4), trial(5, fail="The hedgehog was in the way."), trial(6, wrong=1)],
    )
    for _ in range(2):
        (good, *bad), (flight, fault) = compute(trials, path)
        assert good.result["square"] == 16
        assert bad == [None, None]
        assert flight.why == "The hedgehog was in the way."
        assert fault.why.startswith("TypeError: ")
    assert len(path.read_text().splitlines()) == 1


@pytest.mark.table("left", [1, 5, 60])
def test_a_kill_loses_at_most_the_line_that_was_being_written(tmp_path, left):
    path = tmp_path / "t.jsonl"
    whole, _ = compute([trial(1), trial(2)], path)
    content = path.read_bytes()
    path.write_bytes(content[: content.index(b"\n") + 1 + left])
    with Store(path) as store:
        assert [store.get(trial(1)), store.get(trial(2))] == [whole[0], None]
    rows, _ = compute([trial(1), trial(2)], path)
    assert [row.result for row in rows] == [row.result for row in whole]
    assert all(json.loads(line) for line in path.read_text().splitlines())


def test_a_damaged_line_is_refused_and_left_as_it_is(tmp_path):
    path = tmp_path / "t.jsonl"
    path.write_text('{"name": "square"}\n')
    with pytest.raises(TrialsError, match=r"t\.jsonl is damaged in line 1; move it away"):
        Store(path)
    assert path.read_text() == '{"name": "square"}\n'


def test_two_processes_do_not_write_into_one_file(tmp_path):
    refused = pytest.raises(TrialsError, match="Another process writes trials into")
    with Store(tmp_path / "t.jsonl"), refused:
        Store(tmp_path / "t.jsonl")
    Store(tmp_path / "t.jsonl").close()


def test_the_digest_is_of_what_is_computed_not_of_where(tmp_path):
    def of(folder):
        world = tmp_path / folder / "a.world"
        return trial(inputs={"world": str(world), "content": file_digest(world)}).digest

    for folder in ("here", "there"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "a.world").write_text("<sdf/>")
    assert of("here") == of("there")
    (tmp_path / "there/a.world").write_text("<sdf> </sdf>")
    assert of("here") != of("there")


def test_how_many_trials_there_are_is_told_before_the_first_one_is_done(tmp_path, capsys):
    with Store(tmp_path / "t.jsonl") as store:
        run_trials([trial(3), trial(4)], store, ThisProcess(), "test")
    assert "0/2 done" in capsys.readouterr().err


# -- versions -----------------------------------------------------------------------------------------------


def test_rows_of_another_version_are_told_of(tmp_path, monkeypatch, capsys):
    """Two states of edited sources are two versions, though git has one commit for both."""
    for version in ("abc+changes.1", "abc+changes.2", "abc+changes.2"):
        monkeypatch.setattr(run, "version", lambda version=version: version)
        with Store(tmp_path / "t.jsonl") as store:
            run_trials([trial(3)], store, ThisProcess(), "test")
    assert capsys.readouterr().err.count("Another version of the code computed 1 of them") == 2


def test_a_mixture_of_versions_is_one_sentence():
    rows = [Row("x", "0", version, "", 0.0, 0.0, 0.0, None) for version in ("a", "b", "a")]
    assert several_versions(rows) == "Different versions of the code computed these 3 trials: 2 by a, 1 by b."
    assert several_versions(rows[::2]) is None


# -- who runs them ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def two_processes():
    with open_workers(2) as workers:
        yield workers


def test_order_and_number_of_workers_change_nothing(two_processes, tmp_path):
    trials = [trial(number) for number in range(6)]
    alone, _ = compute(trials, tmp_path / "alone.jsonl")
    backwards, _ = compute(trials[::-1], tmp_path / "backwards.jsonl")
    several, _ = compute(trials, tmp_path / "several.jsonl", two_processes)
    (failed,), _ = compute([trial(7, fail="No.")], tmp_path / "t.jsonl", two_processes)
    assert failed is None
    results = [row.result for row in alone]
    assert [row.result for row in several] == [row.result for row in backwards[::-1]] == results


def temporary_folder(_):
    return tempfile.gettempdir()


def test_what_killed_workers_leave_in_the_temporary_folder_goes_with_them(two_processes):
    ((_, folder),) = two_processes.results(temporary_folder, ["any"])
    assert f"_of_process_{os.getpid()}_" in folder
    assert folder not in os.environ.values()  # what this process starts later would not find it
    workers = DaskWorkers.__new__(DaskWorkers)
    workers._cluster, workers._scratch = SimpleNamespace(workers={}), scratch_folder("test")
    (Path(workers._scratch.name) / "left.world").touch()
    workers.kill()
    assert not Path(workers._scratch.name).exists()


def die_once(folder):
    if not (folder / "died").exists():
        (folder / "died").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "alive"


def test_a_killed_worker_costs_its_trial_only_and_another_one_runs_it_again(two_processes, tmp_path):
    """Also where the processes are those of a scheduler."""
    trials = [Trial("dies", die_once, {"folder": tmp_path}), trial(1)]
    with open_workers(scheduler=two_processes.address) as workers:
        rows, failed = compute(trials, tmp_path / "t.jsonl", workers)
    assert not failed
    assert [row.result for row in rows] == ["alive", {"square": 1, "third": 1 / 3, "drawn": "<svg/>"}]


def test_a_worker_without_the_workspace_is_refused(two_processes, monkeypatch):
    """It would end at its first trial, and the campaign would wait for ever."""
    monkeypatch.setattr(dask_workers, "PACKAGE", "not_installed_there")
    with pytest.raises(TrialsError, match=r"cannot import .*: tcp://.*source devel/setup.bash"):
        open_workers(scheduler=two_processes.address)


def test_a_scheduler_without_workers_is_told_of(capsys):
    from distributed import LocalCluster

    nobody = LocalCluster(n_workers=0, processes=False, dashboard_address=None, protocol="tcp")
    with nobody, open_workers(scheduler=nobody.scheduler_address):
        pass
    assert "No worker has joined" in capsys.readouterr().err


class Dead(ThisProcess):
    def results(self, run, tasks):
        for task in tasks:
            yield task, RuntimeError("KilledWorker")


def test_what_measures_wall_time_runs_last_in_this_process(tmp_path):
    timed = Trial("timed", os.getpid, {}, alone=True)
    (row, other), (failed,) = compute([timed, trial(1)], tmp_path / "t.jsonl", Dead())
    assert row.result == os.getpid()
    assert other is None
    assert failed.why == WORKER_DIED


HALF_MADE = """
from flights.trials.workers import end, interrupted

class HalfMade:
    def __del__(self):
        raise AttributeError

def interrupted_while_it_is_made():
    thing = HalfMade()
    raise KeyboardInterrupt

try:
    interrupted_while_it_is_made()
except KeyboardInterrupt:
    code = interrupted("Interrupted.")
end(code)
"""


def test_what_ctrl_c_leaves_half_made_says_nothing():
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, ROOT.glob("src/**/src")))}
    command = [sys.executable, "-c", HALF_MADE]
    told = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=200.0)
    assert (told.returncode, told.stderr) == (INTERRUPTED, "Interrupted.\n")


HELD = """
import multiprocessing, time
from flights.trials.workers import interrupted, end
def work(queue):
    time.sleep(60)
if __name__ == "__main__":
    spawn = multiprocessing.get_context("spawn")
    queue = spawn.Queue()
    spawn.Process(target=work, args=(queue,)).start()
    end(interrupted("Interrupted."))
"""


def test_semaphores_of_workers_are_freed_after_ctrl_c(tmp_path):
    """Else Python's tracker of them warns of leaks after the last sentence. The worker is just starting."""
    (tmp_path / "held.py").write_text(HELD)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, ROOT.glob("src/**/src")))}
    command = [sys.executable, str(tmp_path / "held.py")]
    told = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=200.0)
    assert (told.returncode, told.stderr) == (INTERRUPTED, "Interrupted.\n")


def test_one_worker_is_this_process():
    with open_workers(1) as workers:
        assert isinstance(workers, ThisProcess)


def test_an_interrupted_trial_clears_up_what_it_has_started(tmp_path):
    """Else a graph of nodes, or a build, would go on without anybody."""
    script = (
        "import signal, sys; from test_trials import *\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "folder = Path(sys.argv[1])\n"
        "try: compute([Trial('waits', wait_and_clear, {'folder': folder}, alone=True)], folder / 't.jsonl')\n"
        "except KeyboardInterrupt: sys.exit(7)\n"
    )
    libraries = [
        str(Path(__file__).parent),
        *map(str, ROOT.glob("src/**/src")),
        os.environ.get("PYTHONPATH", ""),
    ]
    here = {**os.environ, "PYTHONPATH": os.pathsep.join(libraries)}
    command = [sys.executable, "-c", script, str(tmp_path)]
    with subprocess.Popen(command, env=here, preexec_fn=signals_pass_through) as running:
        end = time.monotonic() + PATIENCE_S
        while not (tmp_path / "started").exists():
            assert time.monotonic() < end
            time.sleep(0.05)
        running.send_signal(signal.SIGINT)
        assert running.wait(PATIENCE_S) == 7
    assert (tmp_path / "cleared").exists()
    assert (tmp_path / "t.jsonl").read_bytes() == b""


def signals_pass_through():
    """Whatever blocked signals in the process that runs the tests."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT,))


def wait_and_clear(folder):
    try:
        (folder / "started").touch()
        while True:  # a signal just before one long sleep would count only after it
            time.sleep(0.1)
    finally:
        (folder / "cleared").touch()


# -- files --------------------------------------------------------------------------------------------------


def test_what_json_does_not_know_becomes_plain():
    told = plain({1: (math.inf, np.nan, np.int64(3)), "row": Row("x", *["a"] * 6, Path("/b")), "svg": b"<>"})
    assert told["1"] == [None, None, 3]
    assert told["row"]["result"] == "/b"
    assert told["svg"] == "<>"


def test_a_file_that_cannot_be_written_stays_as_it_was(tmp_path, monkeypatch):
    path = tmp_path / "x"
    replace_file(path, "before")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        replace_file(path, "after")
    assert path.read_text() == "before"
    assert [each.name for each in tmp_path.iterdir()] == ["x"]


def test_a_full_disk_gives_one_sentence_and_no_traceback_at_the_end(tmp_path):
    store = Store(tmp_path / "t.jsonl")
    store._stream.close()
    store._stream = open("/dev/full", "ab")  # noqa: SIM115
    row = Row("a", "digest", "commit", "2026-11-28", 1.0, 1.0, 0.5, {"x": 1})
    with pytest.raises(
        TrialsError, match=r"Cannot write .*t\.jsonl: No space left on device; free some space"
    ):
        store.add(row)
    store.close()  # what is still buffered cannot be written either
    assert store._stream.closed
