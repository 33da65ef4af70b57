"""Given a surveyor's decisions, they stay when the findings are made anew."""

import errno
import json
import os
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from PIL import Image

from flight_basics.errors import ReportError
from inspection.files import whole as whole_files
from inspection.findings import command
from inspection.findings.command import main
from inspection.findings.findings_file import (
    SearchRecord,
    read_findings,
    read_search,
    with_decisions,
    write_findings,
)
from inspection.findings.merging import Finding
from inspection.findings.pairing import pairs_of

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


def test_what_was_dismissed_is_judged_again_where_it_is_many_times_larger():
    dismissed = replace(RUST, status="dismissed", remark="label")
    (now,) = with_decisions([dismissed], [replace(RUST, area_m2=3.0, length_m=3.0)])
    assert (now.id, now.status) == (RUST.id, "under review")
    assert "label" in now.remark


def test_of_two_that_have_grown_into_one_the_weightier_decision_counts_and_both_remarks_stay():
    at = (((0.0, 0.0, 0.0),), ((0.2, 0.0, 0.0),))
    before = [
        replace(RUST, id=k, position_m=places[0], places_m=places, status=status, remark=f"spot {k}")
        for k, places, status in zip((4, 5), at, ("dismissed", "confirmed"))
    ]
    now = with_decisions(before, [replace(RUST, position_m=(0.1, 0.0, 0.0), places_m=(*at[0], *at[1]))])
    assert [(each.status, each.remark) for each in now] == [("confirmed", "spot 4; spot 5")]


def test_a_judged_finding_stays_even_if_it_is_not_found_again():
    confirmed = replace(CRACK, status="confirmed")
    assert with_decisions([RUST, confirmed], []) == [confirmed]


def test_the_nearest_pairs_of_one_kind_count():
    near = replace(RUST, id=5, position_m=(0.0, 0.05, 0.0))
    assert pairs_of([RUST], [replace(RUST, position_m=(0.0, 0.2, 0.0)), near]) == [(0, 1)]
    assert pairs_of([RUST], [replace(CRACK, position_m=RUST.position_m)]) == []


def test_a_full_disk_leaves_the_old_file_whole_and_no_rest(tmp_path, monkeypatch):
    path = tmp_path / "findings.json"
    write_findings(path, SearchRecord((RUST,)))

    def full(descriptor):
        os.truncate(descriptor, 10)
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(whole_files, "settle", full)
    with pytest.raises(ReportError, match=r"findings\.json cannot be written: No space left on device\."):
        write_findings(
            path,
            SearchRecord(
                (
                    RUST,
                    CRACK,
                )
            ),
        )
    assert read_findings(path) == [RUST]
    assert list(tmp_path.iterdir()) == [path]


def test_the_command_decides_and_refuses_in_one_sentence(tmp_path, capsys):
    path = tmp_path / "findings.json"
    write_findings(
        path,
        SearchRecord(
            (
                RUST,
                CRACK,
            )
        ),
    )
    assert main([str(tmp_path), "--decide", "2", "under review", "--remark", "look again"]) == 0
    assert read_findings(path)[1] == replace(CRACK, status="under review", remark="look again")
    for wrong in (["3", "confirmed"], ["2", "fine"], ["x", "new"]):
        capsys.readouterr()
        assert main([str(tmp_path), "--decide", *wrong]) == 1
        assert capsys.readouterr().err.count("\n") == 1
    assert read_findings(path)[1].status == "under review"


def test_two_findings_of_one_number_are_refused(tmp_path):
    path = tmp_path / "findings.json"
    write_findings(path, SearchRecord((RUST, replace(CRACK, id=RUST.id))))
    with pytest.raises(ReportError, match=r"findings\.json: Two findings have the same id"):
        read_findings(path)


def crack(number, *places_m, **more):
    """A crack through places."""
    points = np.array(places_m)
    length_m = float(np.linalg.norm(points[-1] - points[0]))
    middle = tuple(points.mean(axis=0).tolist())
    return Finding(
        number, "crack", middle, (1.0, 0.0, 0.0), length_m, 0.0, ("1.jpg",), places_m=places_m, **more
    )


def along(low, high, y=0.0):
    return tuple((0.0, y, float(z)) for z in np.arange(low, high, 0.05))


LONG = crack(7, *along(0.0, 3.0), status="dismissed", remark="shadow of a seam")


@pytest.mark.table(
    ("places_m", "is_same"),
    [
        (along(0.0, 3.0, 0.05), True), (along(2.0, 2.5), True), (along(1.0, 1.2, 0.3), False),
        (along(1.4, 1.6, 1.6), False),
        (along(2.95, 3.9), False), (along(-1.0, 5.0), True),
    ],
)  # fmt: skip
def test_a_decision_stays_with_what_lies_there(places_m, is_same):
    """Half of the smaller one lies within 0.15 m of the other."""
    now = with_decisions([LONG], [crack(1, *places_m)])
    (found,) = (each for each in now if each.places_m == places_m)
    assert (found.id, found.status) == ((7, "dismissed") if is_same else (8, "new"))


@pytest.mark.table(("away_m", "is_same"), [(0.2, True), (0.25, False), (1.6, False)])
def test_findings_without_places_are_known_by_their_middles(away_m, is_same):
    """0.15 m and half of the shorter one's length."""
    old = replace(LONG, places_m=(), position_m=(0.0, 0.0, 1.0))
    new = replace(CRACK, id=1, position_m=(0.0, away_m, 1.0), length_m=0.12)
    (found,) = (each for each in with_decisions([old], [new]) if each.length_m == 0.12)
    assert (found.id == 7) == is_same


def test_thousands_of_findings_are_paired_in_little_memory():
    y, z = (each.ravel().tolist() for each in np.meshgrid(np.arange(70.0), np.arange(70.0)))
    before = [replace(RUST, id=k + 1, position_m=(0.0, *place)) for k, place in enumerate(zip(y, z))]
    tracemalloc.start()
    pairs = pairs_of(before, before)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert pairs == [(k, k) for k in range(4900)]
    assert peak < 50e6


def folder_of(tmp_path, **damage):
    """Two photographs of a wall."""
    for name in ("1.jpg", "2.jpg"):
        Image.new("RGB", (64, 48), (120, 125, 120)).save(tmp_path / name)
        pose = {"position_m": [0.0, 0.0, 0.0], "orientation_xyzw": [-0.5, 0.5, -0.5, 0.5]}
        (tmp_path / name).with_suffix(".json").write_text(json.dumps(pose))
    calibration = {
        "image_width": 64,
        "image_height": 48,
        "camera_matrix": {"data": [55.4, 0, 31.5, 0, 55.4, 23.5, 0, 0, 1]},
    }
    (tmp_path / "calibration.yaml").write_text(json.dumps(calibration))
    corners = np.array(((3.0, -5.0, -5.0), (3.0, 5.0, -5.0), (3.0, 0.0, 8.0)))
    trimesh.Trimesh(corners, [[0, 1, 2]]).export(tmp_path / "wall.stl")
    return [str(tmp_path), "--mesh", str(tmp_path / "wall.stl")]


def test_what_a_surveyor_decides_while_findings_runs_is_kept(tmp_path, monkeypatch):
    given = folder_of(tmp_path)
    path = tmp_path / "findings.json"
    write_findings(path, SearchRecord((RUST, CRACK), ("1.jpg",)))
    search = command.search_folders

    def slow(*more):
        assert main([str(tmp_path), "--decide", "2", "confirmed", "--remark", "through"]) == 0
        return replace(search(*more), findings=(RUST, CRACK))

    monkeypatch.setattr(command, "search_folders", slow)
    assert main(given) == 0
    assert [(each.status, each.remark) for each in read_findings(path)] == [
        ("new", ""),
        ("confirmed", "through"),
    ]


def test_the_file_tells_what_was_searched_and_what_was_left_out(tmp_path, capsys):
    given = folder_of(tmp_path)
    (tmp_path / "2.jpg").write_bytes(b"")
    assert main(given) == 0
    told = read_search(tmp_path / "findings.json")
    assert (told.searched, [each.name for each in told.left_out]) == (("1.jpg",), ["2.jpg"])
    assert "2.jpg: The file is empty" in capsys.readouterr().err


def test_where_nothing_can_be_searched_the_command_fails_and_the_file_stays(tmp_path, capsys):
    given = folder_of(tmp_path)
    write_findings(tmp_path / "findings.json", SearchRecord((RUST,), ("1.jpg", "2.jpg")))
    for name in ("1.jpg", "2.jpg"):
        (tmp_path / name).write_bytes(b"")
    assert main(given) == 1
    told = capsys.readouterr()
    assert "rust" not in told.out
    assert told.err.count("\n") == 1
    assert read_findings(tmp_path / "findings.json") == [RUST]
