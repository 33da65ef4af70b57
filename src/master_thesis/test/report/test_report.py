"""The report: its smallest run, what it keeps, and how it is interrupted."""

from __future__ import annotations

import contextlib
import io
import json
import math
import re
import signal
import sys
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path

import pytest

from flights.trials.store import Store
from flights.trials.trial import Failed, Row
from flights.trials.workers import ThisProcess
from master_thesis.chapter_8 import __main__ as command
from master_thesis.chapter_8.plan import chosen, plan
from master_thesis.chapter_8.whole_page import write_whole_page
from master_thesis.experiment_2 import pieces as experiment_2
from master_thesis.experiment_2.trial import TrialParameters
from master_thesis.experiment_2.variations import variation_parameters
from master_thesis.report.page import origin, render
from master_thesis.report.pdf import write_pdf
from master_thesis.report.piece import TRIALS, Piece
from master_thesis.report.size import EXPERIMENTS, FULL, QUICK, SMALLEST

PART = "experiment_1"
"""Its flights are 1.5 m long."""


def arguments(folder):
    return ["--smallest", "--no-pdf", "--workers", "1", "--out", str(folder)]


def shortly_observed(*given):
    """Return a variation of Experiment 2 that is over when the UAV has left (after 2.4 s at most)."""
    return replace(variation_parameters(*given), trial=TrialParameters(observe_s=4.0))


class CtrlC(ThisProcess):
    """Presses Ctrl-C when the first trial is finished."""

    def results(self, run, tasks):
        yield tasks[0], run(tasks[0])
        signal.raise_signal(signal.SIGINT)


@dataclass(frozen=True)
class Call:
    """What a call of the report has left. lines: the pieces on the disk."""

    code: int
    errors: str
    page: str
    lines: list[dict]

    @property
    def results(self) -> dict[str, dict]:
        return {line["name"]: line["result"] for line in self.lines}


def called(folder, workers, *words) -> Call:
    """Call the smallest report."""
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stderr(io.StringIO()) as errors:
        patch.setattr(sys, "unraisablehook", sys.unraisablehook)  # an interrupt replaces it
        patch.setattr(command, "open_workers", lambda _: contextlib.nullcontext(workers))
        patch.setattr(experiment_2, "variation_parameters", shortly_observed)
        code = command.main([*arguments(folder), *words])
    page = (folder / "index.html").read_text(encoding="utf-8")
    lines = [json.loads(line) for line in (folder / TRIALS).read_text().split("\n")[:-1]]
    return Call(code, errors.getvalue(), page, lines)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("report")


@pytest.fixture(scope="module")
def interrupted(folder):
    """The report of one experiment, interrupted after its first piece."""
    return called(folder, CtrlC(), "--only", PART)


@pytest.fixture(scope="module")
def part(folder, interrupted):
    """The next call, which comes to its end."""
    return called(folder, ThisProcess(), "--only", PART)


@pytest.fixture(scope="module")
def whole(folder, part):
    """A call for all other experiments."""
    return called(folder, ThisProcess())


@pytest.fixture(params=["part", pytest.param("whole", marks=pytest.mark.long)])
def report(request):
    return request.getfixturevalue(request.param)


@pytest.mark.long
@pytest.mark.flight
@pytest.mark.timeout(900)  # after a change of kernels the first run compiles them
def test_ctrl_c_keeps_what_is_finished_and_the_next_call_goes_on(interrupted, part):
    assert interrupted.code == 130
    assert "Interrupted; all finished pieces are kept; the next call goes on from here." in interrupted.errors
    assert part.code == 0, part.errors
    pieces = chosen(plan(SMALLEST), [PART], [])
    before, of = map(int, re.search(r"(\d+) of (\d+) trials are there from before", part.errors).groups())
    assert (before, of) == (1, len(pieces))
    assert sorted(line["name"] for line in part.lines) == sorted(piece.name for piece in pieces)


@pytest.mark.long
@pytest.mark.flight
@pytest.mark.timeout(900)
def test_ctrl_c_writes_the_page_of_what_is_finished(interrupted, part):
    first, *others = part.lines
    assert interrupted.lines == [first]
    titles = {piece.name: escape(piece.title) for piece in plan(SMALLEST)}
    assert titles[first["name"]] not in interrupted.page  # it is not among the missing ones
    assert all(titles[line["name"]] in interrupted.page for line in others)


@pytest.mark.long
@pytest.mark.flight
@pytest.mark.timeout(900)
def test_the_page_needs_nothing_else_and_shows_the_pieces_numbers(report):
    sources = re.findall(r'(?:src|href)="([^"]*)"', report.page)
    assert sources
    assert all(source.startswith(("data:image/svg+xml;base64,", "#")) for source in sources)
    assert "@import" not in report.page
    assert "url(" not in report.page
    flown = report.results["experiment_1_forest_improved_1_1.5m"]
    assert flown["reached_goal"] is True
    assert f"{flown['computation_ms']:.3f}" in report.page


@pytest.mark.long
@pytest.mark.flight
@pytest.mark.timeout(900)
def test_every_link_of_the_contents_leads_somewhere(report):
    targets = set(re.findall(r'href="#([^"]+)"', report.page))
    assert {"summary", "origin", "experiment_1"} <= targets
    assert targets <= set(re.findall(r'id="([^"]+)"', report.page))


@pytest.mark.long
@pytest.mark.flight
@pytest.mark.timeout(900)
def test_the_whole_page_has_every_piece(whole):
    assert whole.code == 0, whole.errors
    assert sorted(whole.results) == sorted(piece.name for piece in plan(SMALLEST))
    mapped = whole.results["experiment_3_ust_1_3s"]
    assert f"{mapped['open']['map_error_p95_m']:.3f}" in whole.page
    for piece in plan(SMALLEST):
        assert f'<section id="{piece.experiment}">' in whole.page
    assert 'class="missing"' not in whole.page
    assert "not computed" not in whole.page
    assert whole.page.count('<span class="basis">one flight of each</span>') == 4  # the smallest flies once
    assert "One flight of each lidar." in whole.page


@pytest.mark.long
@pytest.mark.flight
@pytest.mark.timeout(900)
def test_without_gnss_it_flies_back_and_lands_where_it_started(whole):
    home = whole.results["without_gnss_room_ust_1_3s"]
    assert home["flown"]
    assert not home["contact"]
    assert home["landed_off_m"] < 0.3
    start, *path = home["path_xy"]
    assert max(math.dist(start, place) for place in path) > 1.0  # 3 s at 0.6 m/s, less the acceleration


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
    assert len(flown) == 4 * 3
    placements = sum(e.given.get("count", 0) for e in pieces if e.experiment == "experiment_2")
    assert placements == 3 * 2 * 20


def test_the_quick_report_is_a_part_of_the_whole():
    whole = {each.digest for each in plan(FULL) if not each.alone}
    assert {each.digest for each in plan(QUICK) if not each.alone} < whole


def test_the_quick_report_takes_five_minutes_by_its_pieces_costs():
    """Two processes fly; what measures wall time runs alone."""
    pieces = plan(QUICK)
    alone_s, shared_s = (sum(p.cost_s for p in pieces if p.alone is alone) for alone in (True, False))
    assert alone_s + shared_s / 2.0 < 5.2 * 60.0
    assert {each.experiment for each in pieces} == set(EXPERIMENTS)


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
    page, store = tmp_path / "index.html", Store(tmp_path / TRIALS)
    text = write_whole_page(page, size, store, [Failed(first, "It broke.")])
    assert f"{first.title}: It broke." in text
    assert text.count('class="missing"') == len(EXPERIMENTS)
    assert text.count(">not computed<") == len(EXPERIMENTS)
    assert '<td class="n">0</td>' not in text, "nothing agrees and nothing differs where nothing was computed"
    assert page.read_text(encoding="utf-8") == text


def test_a_report_of_several_versions_of_the_code_says_so(tmp_path):
    with Store(tmp_path / TRIALS) as store:
        for piece, commit in zip(plan(QUICK), ("abc", "abc+changes.1")):
            store.add(Row(piece.name, piece.digest, commit, "2026-11-20T12:00:00", 1.0, 1.0, 0.5, None))
        told = origin(QUICK.name, plan(QUICK), store)
    assert told.mixture == (
        "Different versions of the code computed these 2 trials: 1 by abc, 1 by abc+changes.1."
    )
    assert told.mixture in render([], told)


def test_a_report_with_a_piece_that_failed_ends_with_1(tmp_path, monkeypatch, capsys):
    piece = Piece("flight", int, {"x": "no number"}, experiment="experiment_1")
    monkeypatch.setattr("master_thesis.chapter_8.__main__.plan", lambda _: [piece])
    assert command.main(["--smallest", "--no-pdf", "--workers", "1", "--out", str(tmp_path)]) == 1
    assert "1 of 1 pieces failed, see the page; call again" in capsys.readouterr().err


def test_unknown_names_are_refused_in_a_sentence(tmp_path, capsys):
    with pytest.raises(SystemExit) as refused:
        command.main(["--only", "experiment_9", "--out", str(tmp_path)])
    assert refused.value.code == 2
    assert "experiment_9" in capsys.readouterr().err
    assert command.main(["--smallest", "--only", "experiment_4", "--out", str(tmp_path)]) == 2  # it has none
    assert "A report of this size has no such piece." in capsys.readouterr().err


def test_without_a_browser_there_is_a_sentence_in_place_of_the_pdf(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / "index.html").write_text("<p>x</p>")
    said = write_pdf(tmp_path / "index.html", tmp_path / "report.pdf")
    assert said.startswith("No PDF was made")
    assert not (tmp_path / "report.pdf").exists()


def test_the_page_names_all_that_only_takes():
    page = (Path(__file__).parents[2] / "doc/report.md").read_text(encoding="utf-8")
    (line,) = re.findall(r"(?m)^- `--only`.*$", page)
    between = {"experiment_2", "experiment_3"}  # "`experiment_1` to `experiment_4`"
    assert set(re.findall(r"`(\w+)`", line)) | between == set(EXPERIMENTS)
