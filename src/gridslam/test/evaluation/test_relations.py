"""The relations metric on hand-worked cases, and on the Intel log's raw odometry where there is the data."""

import gzip
import json
import math
from pathlib import Path

import numpy as np
import pytest

from gridslam.errors import EvaluationError
from gridslam.evaluation import Relations, poses_at, read_relations, read_tum, relation_errors, write_tum
from gridslam.evaluation.command import main
from gridslam.trajectory import Trajectory

DATA = Path(__file__).resolve().parents[5] / "shared/data"


def trajectory(*rows):
    rows = np.array(rows, dtype=float)
    return Trajectory(rows[:, 0], rows[:, 1:])


def test_error_is_that_of_the_relative_pose_whatever_the_frame():
    # Given a trajectory turned by 90 degrees as a whole: forward is +y. It went 3 m, truly 2 m, 0.4 m left.
    estimate = trajectory((0.0, 5.0, 5.0, math.pi / 2), (1.0, 5.0, 8.0, math.pi / 2 + 0.3))
    relations = Relations(np.array([[0.0, 1.0]]), np.array([[2.0, 0.4, 0.1]]))
    errors = relation_errors(estimate, relations)
    assert errors.translation_mean_m == pytest.approx(math.hypot(1.0, 0.4))
    assert errors.rotation_mean_deg == pytest.approx(math.degrees(0.2))


def test_mean_and_deviation_also_of_the_squares():
    # Given three relations that are wrong by 1, 2 and 6 m
    estimate = trajectory((0.0, 0.0, 0.0, 0.0), (1.0, 10.0, 0.0, 0.0))
    relations = Relations(
        np.array([[0.0, 1.0]] * 3), np.array([[9.0, 0.0, 0.0], [12.0, 0.0, 0.0], [10.0, 6.0, 0.0]])
    )
    errors = relation_errors(estimate, relations)
    assert errors.relations == 3
    assert errors.translation_mean_m == pytest.approx(3.0)
    assert errors.translation_std_m == pytest.approx(math.sqrt(14.0 / 3.0))  # (4 + 1 + 9) / 3
    assert errors.translation_squared_mean_m2 == pytest.approx(41.0 / 3.0)
    assert errors.translation_squared_std_m2 == pytest.approx(
        math.sqrt(((1.0 - 41 / 3) ** 2 + (4.0 - 41 / 3) ** 2 + (36.0 - 41 / 3) ** 2) / 3.0)
    )


def test_rotation_error_is_taken_the_short_way_round():
    estimate = trajectory((0.0, 0.0, 0.0, 3.0), (1.0, 0.0, 0.0, -3.0))
    relations = Relations(np.array([[0.0, 1.0]]), np.array([[0.0, 0.0, 0.0]]))
    assert relation_errors(estimate, relations).rotation_mean_deg == pytest.approx(
        math.degrees(2 * math.pi - 6.0)
    )


def test_trajectory_is_interpolated_also_across_pi():
    estimate = trajectory((0.0, 0.0, 0.0, math.pi - 0.1), (2.0, 4.0, -2.0, -math.pi + 0.1))
    x, y, yaw = poses_at(estimate, np.array([1.0]))[0]
    assert (x, y) == pytest.approx((2.0, -1.0))
    assert abs(math.remainder(yaw - math.pi, 2 * math.pi)) < 1e-9


def along_x(first_s, last_s):
    """Every second from one to the other, at 1 m/s along x, from the origin at 0 s."""
    stamps = np.arange(first_s, last_s + 1.0)
    return trajectory(*((stamp, stamp, 0.0, 0.0) for stamp in stamps))


def advances(*stamps, metres):
    return Relations(np.array(stamps), np.array([[metres, 0.0, 0.0]] * len(stamps)))


def test_relations_outside_the_trajectorys_time_are_left_out_and_counted():
    # Given ten seconds, and relations 0.5 m off: two inside, two half outside, one outside altogether
    relations = advances((10.0, 12.0), (18.0, 20.0), (9.0, 11.0), (19.0, 21.0), (30.0, 32.0), metres=2.5)
    errors = relation_errors(along_x(10.0, 20.0), relations)
    assert (errors.relations, errors.relations_outside) == (2, 3)
    assert errors.translation_mean_m == pytest.approx(0.5)  # poses held at the ends would give 0.5 to 2.5


def test_relations_up_to_a_millisecond_beyond_the_ends_are_inside():
    relations = advances((9.9991, 20.0009), (9.9989, 12.0), metres=10.0)
    assert relation_errors(along_x(10.0, 20.0), relations).relations == 1


def test_no_relation_in_the_trajectorys_time_is_refused_with_a_sentence():
    with pytest.raises(EvaluationError, match=r"None of the 1 relations .* 10.000 to 20.000 s; .* 30.000"):
        relation_errors(along_x(10.0, 20.0), advances((30.0, 32.0), metres=2.0))


def test_command_says_how_many_relations_were_outside(tmp_path, capsys):
    write_tum(tmp_path / "path.tum", along_x(10.0, 20.0))
    lines = ("10 12 2 0 0 0 0 0", "10.5 12.5 2.25 0 0 0 0 0", "19 21 2 0 0 0 0 0")
    (tmp_path / "relations").write_text("\n".join(lines))
    figures = tmp_path / "figures.json"
    files = [str(tmp_path / "path.tum"), str(tmp_path / "relations")]
    assert main(["relations", *files, "--json", str(figures)]) == 0
    assert "relations_outside" in capsys.readouterr().out
    written = json.loads(figures.read_text())
    assert (written["all"]["relations"], written["all"]["relations_outside"]) == (2, 1)
    assert (written["exact"]["relations"], written["exact"]["relations_outside"]) == (1, 0)
    assert written["all"]["translation_mean_m"] == pytest.approx(0.125)
    assert written["exact"]["translation_mean_m"] == pytest.approx(0.0, abs=1e-9)


def test_exact_relations_have_both_stamps_within_a_millisecond_of_a_scan():
    relations = Relations(
        np.array([[1.0, 2.0], [1.0009, 1.9991], [1.0, 2.0011], [1.5, 2.0]]), np.zeros((4, 3))
    )
    assert len(relations.exact(np.array([1.0, 2.0]))) == 2


def test_tum_file_keeps_the_trajectory(tmp_path):
    written = trajectory((976052857.295471, 1.25, -3.5, 3.1), (976052858.5, 2.0, 0.125, -3.1))
    write_tum(tmp_path / "path.tum", written)
    read = read_tum(tmp_path / "path.tum")
    assert np.abs(read.stamps_s - written.stamps_s).max() < 1e-6
    assert np.allclose(read.poses_in_map, written.poses_in_map, atol=1e-7)


@pytest.mark.table(
    ("text", "sentence"),
    [
        ("1 2 3\n", "8 finite numbers"),
        ("", "8 finite numbers"),
        ("a b c d e f g h\n", "line 1: 'a' is not a finite number"),
        ("# text\n1 0 0 0 0 0 0 1\n2 0 0 0\n", "line 3: has 4 numbers"),
        ("1 0 0 0 0 0 0 nan\n", "8 finite numbers"),
        ("1 0 0 0 0 0 0 0\n", "not an orientation"),
        ("2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", "back in time"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_bad_trajectory_files_are_refused_with_a_sentence(tmp_path, text, sentence):
    path = tmp_path / "path.tum"
    path.write_text(text)
    with pytest.raises(EvaluationError, match=sentence):
        read_tum(path)


def test_quaternions_of_any_length_turn_alike(tmp_path):
    (tmp_path / "path.tum").write_text("1 0 0 0 0 0 1 1\n2 0 0 0 0 0 -0.2 0.2\n")
    assert read_tum(tmp_path / "path.tum").poses_in_map[:, 2] == pytest.approx([math.pi / 2, -math.pi / 2])


@pytest.mark.table(
    ("content", "sentence"),
    [
        (b"", "is empty"),
        (b"1 2 nan 0 0 0 0 0\n", "line 1: 'nan'"),
        (b"these are no relations\n", "'these' is not a finite number"),
        (b"\xff\xfe\x00", "not text"),
        (gzip.compress(b"1 2 0 0 0 0 0 0\n" * 999, mtime=0)[:40], "cannot be read"),
        (gzip.compress(bytes(range(256)), mtime=0)[:20] + b"\xff" * 99, "cannot be read"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_bad_relations_files_are_refused_with_a_sentence(tmp_path, content, sentence):
    path = tmp_path / ("relations.gz" if content.startswith(b"\x1f\x8b") else "relations")
    path.write_bytes(content)
    with pytest.raises(EvaluationError, match=sentence):
        read_relations(path)


def test_intel_odometry_errs_as_published():
    """The figure measured for the raw odometry of this log with these relations: 3.25 +- 7.20 m."""
    log, relations_path = DATA / "intel_dense.log.gz", DATA / "intel.relations.gz"
    if not (log.exists() and relations_path.exists()):
        pytest.skip(f"needs the Intel log in {DATA}")
    with gzip.open(log, "rt") as file:
        lines = [line.split() for line in file]
    # FLASER <180 ranges> x y yaw odom_x odom_y odom_yaw stamp host stamp
    rows = np.array([[float(words[188])] + [float(word) for word in words[185:188]] for words in lines])
    _, first = np.unique(rows[:, 0], return_index=True)
    odometry = Trajectory(rows[first, 0], rows[first, 1:])
    exact = read_relations(relations_path).exact(odometry.stamps_s)
    errors = relation_errors(odometry, exact)
    assert errors.relations == 97
    assert errors.translation_mean_m == pytest.approx(3.25, abs=0.005)
    assert errors.translation_std_m == pytest.approx(7.20, abs=0.005)


@pytest.mark.table("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_whatever_system_has_written_a_trajectory(tmp_path, encoding):
    text = "# gemessen in Süd\r\n1.0 2 3 0 0 0 0 1\r\n2.0 2 4 0 0 0 0 1\r\n"
    (tmp_path / "a.tum").write_bytes(text.encode(encoding))
    assert read_tum(tmp_path / "a.tum").poses_in_map[:, 1].tolist() == [3.0, 4.0]
