"""The report: its smallest run as its user starts it, what it keeps, and how it is interrupted."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from master_thesis.errors import FlightError, ResultsError
from master_thesis.report import runner
from master_thesis.report.__main__ import main
from master_thesis.report.page import write_page
from master_thesis.report.pdf import write_pdf
from master_thesis.report.piece import Made, Piece, fingerprint
from master_thesis.report.plan import chosen, plan
from master_thesis.report.runner import Failed, compute
from master_thesis.report.size import EXPERIMENTS, FULL, QUICK, SMALLEST
from master_thesis.report.store import Store

ROOT = Path(__file__).resolve().parents[3]
PATIENCE_S = 250.0


def command(folder, *arguments):
    return [
        *(sys.executable, "-m", "master_thesis.report", "--smallest", "--no-pdf", "--out", str(folder)),
        *arguments,
    ]


def environment():
    libraries = os.pathsep.join(sorted(str(path) for path in ROOT.glob("src/*/src")))
    return {**os.environ, "PYTHONPATH": libraries + os.pathsep + os.environ.get("PYTHONPATH", "")}


def run(folder, *arguments):
    return subprocess.run(
        command(folder, *arguments), env=environment(), capture_output=True, text=True, timeout=PATIENCE_S
    )


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """Interrupt the smallest report after its first piece, then let it end; return (folder, both outputs)."""
    folder = tmp_path_factory.mktemp("report")
    with subprocess.Popen(
        command(folder), env=environment(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as begun:
        said = [next(line for line in begun.stdout if line.startswith("[")), ""]
        begun.send_signal(signal.SIGINT)
        said.append(begun.communicate(timeout=PATIENCE_S)[0])
    return folder, (begun.returncode, "".join(said)), run(folder)


@pytest.mark.flight
@pytest.mark.timeout(2.5 * PATIENCE_S)
def test_ctrl_c_keeps_what_is_finished_and_the_next_call_goes_on(report):
    folder, (code, interrupted), ended = report
    assert code == 130
    assert "Interrupted; every finished piece is kept, and the next call goes on from here." in interrupted
    assert "Traceback" not in interrupted
    assert ended.returncode == 0, ended.stderr
    before = int(re.search(r"(\d+) of 6 pieces are there from before", ended.stdout).group(1))
    assert before >= 1
    assert ended.stdout.count("\n[") == 6 - before
    assert not list((folder / "pieces").glob(".unfinished*"))
    assert {path.name for path in (folder / "pieces").iterdir()} == {
        ".lock",
        *(piece.name for piece in plan(SMALLEST)),
    }


@pytest.mark.flight
@pytest.mark.timeout(2.5 * PATIENCE_S)
def test_the_page_needs_nothing_else_and_shows_the_pieces_numbers(report):
    folder, _, _ = report
    page = (folder / "index.html").read_text(encoding="utf-8")
    sources = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert sources
    assert all(source.startswith(("data:image/svg+xml;base64,", "#")) for source in sources)
    assert "@import" not in page
    assert "url(" not in page
    mapped = json.loads((folder / "pieces/experiment_3_ust_1_8s/piece.json").read_text())["numbers"]
    assert f"{mapped['open']['map_error_p95_m']:.3f}" in page
    flown = json.loads((folder / "pieces/experiment_1_forest_improved_1_6m/piece.json").read_text())[
        "numbers"
    ]
    assert flown["reached_goal"] is True
    assert f"{flown['computation_ms']:.3f}" in page
    for piece in plan(SMALLEST):
        assert f'<section id="{piece.experiment}">' in page
    assert 'class="missing"' not in page
    assert "not computed" not in page
    assert page.count('<span class="basis">one flight of each</span>') == 4  # the smallest flies once
    assert "One flight of each lidar." in page


@pytest.mark.flight
@pytest.mark.timeout(2.5 * PATIENCE_S)
def test_every_link_of_the_contents_leads_somewhere(report):
    page = (report[0] / "index.html").read_text(encoding="utf-8")
    targets = set(re.findall(r'href="#([^"]+)"', page))
    assert {"summary", "origin", "experiment_1"} <= targets
    assert targets <= set(re.findall(r'id="([^"]+)"', page))


# -- pieces and where they are kept -------------------------------------------------------------------------


def square(number, fail=False):
    if fail:
        raise FlightError("The hedgehog was in the way.")
    return Made({"square": number**2}, {"drawn": b"<svg/>"})


def piece(number=3, inputs=None, **given):
    return Piece(
        f"square_{number}", "experiment_1", "a square", square, {"number": number, **given}, inputs or {}
    )


def test_a_piece_is_computed_once_for_the_same_inputs(tmp_path):
    store, said = Store(tmp_path), []
    assert compute([piece()], store, 1, said.append) == []
    done = store.get(piece())
    assert done.numbers == {"square": 9}
    assert done.figure("drawn") == b"<svg/>"
    assert done.facts["took_s"] >= 0.0
    compute([piece()], store, 1, said.append)
    assert sum(line.startswith("[") for line in said) == 1
    assert store.get(piece(inputs={"speed_m_s": 2.0})) is None  # other inputs, another piece


def test_pieces_of_another_version_of_the_code_are_told_of(tmp_path, monkeypatch):
    """Two states of edited sources are two versions, though git has one commit for both."""
    said = []
    for version in ("abc+changes.1", "abc+changes.2", "abc+changes.2"):
        monkeypatch.setattr(runner, "commit", lambda _, version=version: version)
        compute([piece(3)], Store(tmp_path), 1, said.append)
    other = "1 of them were computed by another version of the code; give --out to compute all anew."
    assert said.count(other) == 2


def test_a_piece_that_fails_is_told_of_and_tried_again(tmp_path):
    store, said = Store(tmp_path), []
    failed = compute([piece(4), piece(5, fail=True)], store, 2, said.append)
    assert [each.why for each in failed] == ["The hedgehog was in the way."]
    assert store.get(piece(4)).numbers == {"square": 16}
    assert store.get(piece(5, fail=True)) is None
    assert any("failed: The hedgehog" in line for line in said)


def test_a_fault_in_one_piece_does_not_cost_the_others(tmp_path):
    store = Store(tmp_path)
    failed = compute([piece(4), piece(6, wrong="argument")], store, 2, lambda words: None)
    assert len(failed) == 1
    assert failed[0].why.startswith("TypeError: ")
    assert store.get(piece(4)).numbers == {"square": 16}


def test_two_reports_do_not_write_into_one_folder(tmp_path):
    first, second = Store(tmp_path), Store(tmp_path)
    refused = pytest.raises(ResultsError, match="Another report is being computed")
    with first.alone(), refused, second.alone():
        pytest.fail("both may write")
    with second.alone():
        assert second.get(piece()) is None


def test_an_interrupted_piece_clears_up_what_it_has_started(tmp_path):
    """Else a graph of nodes, or a build, would go on without anybody."""
    script = (
        "import signal, sys; from pathlib import Path; from test_report import *\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "try: compute([clearing_piece(sys.argv[1])], Store(Path(sys.argv[1]) / 'pieces'), 1, print)\n"
        "except KeyboardInterrupt: sys.exit(7)\n"
    )
    here = {
        **environment(),
        "PYTHONPATH": f"{Path(__file__).parent}{os.pathsep}{environment()['PYTHONPATH']}",
    }
    with subprocess.Popen([sys.executable, "-c", script, str(tmp_path)], env=here) as running:
        wait_for((tmp_path / "started").exists)
        running.send_signal(signal.SIGINT)
        assert running.wait(PATIENCE_S) == 7
    assert (tmp_path / "cleared").exists()
    assert list((tmp_path / "pieces").iterdir()) == []


def clearing_piece(folder):
    return Piece("clearing", "experiment_1", "a piece that waits", wait_and_clear, {"folder": folder})


def wait_and_clear(folder):
    try:
        (Path(folder) / "started").touch()
        time.sleep(10 * PATIENCE_S)
    finally:
        (Path(folder) / "cleared").touch()


def wait_for(condition):
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_what_was_left_half_written_counts_for_nothing(tmp_path):
    store = Store(tmp_path)
    (tmp_path / ".unfinished-abc").mkdir()
    (tmp_path / "square_3").mkdir()
    (tmp_path / "square_3/piece.json").write_text('{"digest": ')
    assert store.get(piece()) is None
    compute([piece()], store, 1, lambda words: None)
    assert store.get(piece()).numbers == {"square": 9}
    assert [path.name for path in tmp_path.iterdir()] == ["square_3"]


def test_the_digest_is_of_what_is_computed_not_of_where(tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    for folder in (here, there):
        folder.mkdir()
        (folder / "a.world").write_text("<sdf/>")
    first, second = (
        piece(inputs=fingerprint({"world": str(folder / "a.world")}, world=folder / "a.world"))
        for folder in (here, there)
    )
    assert first.digest == second.digest
    (there / "a.world").write_text("<sdf> </sdf>")
    moved = piece(inputs=fingerprint({"world": str(there / "a.world")}, world=there / "a.world"))
    assert moved.digest != first.digest


# -- what is computed ---------------------------------------------------------------------------------------


def test_the_whole_report_has_every_experiment_and_lidar():
    pieces = plan(FULL)
    assert {each.experiment for each in pieces} == set(EXPERIMENTS)
    names = [each.name for each in pieces]
    assert len(set(names)) == len(names)
    for experiment in ("experiment_3", "experiment_4"):
        lidars = {each.lidar for each in pieces if each.experiment == experiment}
        assert lidars == {"urg", "ust", "utm", "puck", "tim", "m8"}
    flown = {tuple(e.given.items())[:2] for e in pieces if e.experiment == "experiment_1"}
    assert len(flown) == 4 * 2
    placements = sum(e.given.get("count", 0) for e in pieces if e.experiment == "experiment_2")
    assert placements == 3 * 2 * 20


def test_the_quick_report_is_a_part_of_the_whole():
    whole = {each.digest for each in plan(FULL) if not each.alone}
    assert {each.digest for each in plan(QUICK) if not each.alone} < whole


def test_reports_of_all_sizes_can_share_a_folder():
    by_name: dict = {}
    for size in (FULL, QUICK, SMALLEST):
        for each in plan(size):
            by_name.setdefault(each.name, set()).add(each.digest)
    assert {len(digests) for digests in by_name.values()} == {1}


def test_a_part_can_be_chosen():
    some = chosen(plan(FULL), ["experiment_4"], ["urg"])
    assert [each.name for each in some] == [f"experiment_4_urg_{seed}" for seed in (1, 2, 3)]
    assert "experiment_4_tim_15m_2" in {each.name for each in chosen(plan(FULL), [], ["tim"])}


def test_an_empty_report_says_what_is_missing(tmp_path):
    size = QUICK
    first = plan(size)[0]
    text = write_page(tmp_path / "index.html", size, Store(tmp_path / "pieces"), [Failed(first, "It broke.")])
    assert f"{first.title}: It broke." in text
    assert text.count('class="missing"') == len(EXPERIMENTS)
    assert text.count(">not computed<") == len(EXPERIMENTS)
    assert '<td class="n">0</td>' not in text, "nothing agrees and nothing differs where nothing was computed"
    assert (tmp_path / "index.html").read_text(encoding="utf-8") == text


def test_unknown_names_are_refused_in_a_sentence(tmp_path, capsys):
    with pytest.raises(SystemExit) as refused:
        main(["--only", "experiment_9", "--out", str(tmp_path)])
    assert refused.value.code == 2
    assert "experiment_9" in capsys.readouterr().err
    assert main(["--smallest", "--only", "experiment_4", "--out", str(tmp_path)]) == 2  # it has none
    assert "Nothing of that name" in capsys.readouterr().err


def test_without_a_browser_there_is_a_sentence_in_place_of_the_pdf(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / "index.html").write_text("<p>x</p>")
    said = write_pdf(tmp_path / "index.html", tmp_path / "report.pdf")
    assert said.startswith("No PDF was made")
    assert not (tmp_path / "report.pdf").exists()
