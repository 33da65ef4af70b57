"""Given a surveyor's decisions, they stay when the findings are made anew."""

import errno
import json
from dataclasses import replace

import pytest

from inspection_tools.errors import ReportError
from inspection_tools.findings.command import main
from inspection_tools.findings.findings_file import pairs_of, read_findings, with_decisions, write_findings
from inspection_tools.findings.merging import Finding

RUST = Finding(1, "rust", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.2, 0.01, ("1.jpg",))
CRACK = Finding(2, "crack", (0.0, 3.0, 0.0), (1.0, 0.0, 0.0), 0.4, 0.0, ("1.jpg",))


def test_decisions_stay_and_new_findings_get_new_numbers():
    before = [
        replace(RUST, status="dismissed", remark="paint"),
        CRACK,
        replace(CRACK, id=7, position_m=(0, 9, 0)),
    ]
    moved = replace(RUST, position_m=(0.0, 0.1, 0.0), area_m2=0.02)
    other = replace(RUST, id=2, position_m=(0.0, 5.0, 0.0))
    now = with_decisions(before, [other, moved])
    assert [(each.id, each.status, each.remark) for each in now] == [
        (1, "dismissed", "paint"),
        (8, "new", ""),
    ]
    assert now[0].area_m2 == 0.02
    assert now[1].position_m == other.position_m


def test_a_judged_finding_stays_even_if_it_is_not_found_again():
    confirmed = replace(CRACK, status="confirmed")
    assert with_decisions([RUST, confirmed], []) == [confirmed]


def test_the_nearest_pairs_of_one_kind_count():
    near = replace(RUST, id=5, position_m=(0.0, 0.05, 0.0))
    assert pairs_of([RUST], [replace(RUST, position_m=(0.0, 0.2, 0.0)), near]) == [(0, 1)]
    assert pairs_of([RUST], [replace(CRACK, position_m=RUST.position_m)]) == []


def test_a_full_disk_leaves_the_old_file_whole_and_no_rest(tmp_path, monkeypatch):
    path = tmp_path / "findings.json"
    write_findings(path, [RUST])
    write_text = type(path).write_text

    def full(self, text, **how):
        write_text(self, text[: len(text) // 2], **how)
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(type(path), "write_text", full)
    with pytest.raises(ReportError, match=r"findings\.json cannot be written: No space left on device\."):
        write_findings(path, [RUST, CRACK])
    assert read_findings(path) == [RUST]
    assert list(tmp_path.iterdir()) == [path]


def test_the_command_decides_and_refuses_in_one_sentence(tmp_path, capsys):
    path = tmp_path / "findings.json"
    write_findings(path, [RUST, CRACK])
    assert main([str(tmp_path), "--decide", "2", "under review", "--remark", "look again"]) == 0
    assert read_findings(path)[1] == replace(CRACK, status="under review", remark="look again")
    for wrong in (["3", "confirmed"], ["2", "fine"], ["x", "new"]):
        capsys.readouterr()
        assert main([str(tmp_path), "--decide", *wrong]) == 1
        assert capsys.readouterr().err.count("\n") == 1
    assert read_findings(path)[1].status == "under review"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("status", "fine"),
        ("position_m", [0.0, None, 0.0]),
        ("length_m", float("nan")),
        ("id", 1),
        ("places_m", [[0.0, 1.0]]),
        ("places_m", [[0.0, 1.0, float("nan")]]),
        ("places_m", 3),
    ],
)
def test_a_damaged_file_is_refused(tmp_path, key, value):
    path = tmp_path / "findings.json"
    write_findings(path, [RUST, CRACK])
    content = json.loads(path.read_text())
    content["findings"][1][key] = value
    path.write_text(json.dumps(content))
    with pytest.raises(ReportError, match=r"findings\.json"):
        read_findings(path)
