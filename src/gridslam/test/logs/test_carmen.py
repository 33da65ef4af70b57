"""CARMEN logs: lines written by hand are read as the format says, and what is written is read back."""

import gzip
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gridslam.logs.carmen import (
    CarmenError,
    CarmenOdometry,
    CarmenScan,
    flaser_angles,
    format_odometry,
    format_scan,
    planar_scans,
    read_log,
)

INTEL = Path(__file__).resolve().parents[5] / "shared/data/intel_keyframes.log.gz"
FLASER = "FLASER 3 1.00 2.50 81.83 0.5 0.25 0.1 0.4 0.2 0.05 976052857.295471 nohost 0.98"
ROBOTLASER = (
    "ROBOTLASER1 0 -1.0 2.0 1.0 30.0 0.01 0 3 1.0 2.0 31.0 2 7 8 0.5 0.25 0.1 0.4 0.2 0.05 "
    "0.1 0.2 0.3 0.4 0.5 12.25 host 0.98"
)
ODOM = "ODOM 1.0 2.0 0.5 0.75 -0.1 0.0 976052857.3 nohost 1.0"
HEADER = "# CARMEN Logfile\nPARAM robot_length 0.5 1.0 nohost 1.0\n\n"

numbers = st.floats(-1000.0, 1000.0).map(lambda value: round(value, 6))
poses = st.tuples(numbers, numbers, numbers)
ranges = st.lists(st.floats(0.0, 80.0).map(lambda value: round(value, 3)) | st.just(math.inf), min_size=1)


def log(folder, *lines):
    path = folder / "a.log"
    path.write_text(HEADER + "\n".join(lines) + "\n")
    return path


def test_flaser(tmp_path):
    (scan,) = read_log(log(tmp_path, FLASER))
    assert scan.stamp_s == 976052857.295471
    assert scan.ranges_m.tolist() == [1.0, 2.5, math.inf]
    assert (scan.lidar_in_odom, scan.robot_in_odom) == ((0.5, 0.25, 0.1), (0.4, 0.2, 0.05))
    assert scan.range_max_m == 80.0


@pytest.mark.table(
    ("count", "first_deg", "last_deg"),
    [(180, -90, 89), (181, -90, 90), (360, -90, 89.5), (361, -90, 90), (401, -50, 50), (1081, -135, 135)],
)
def test_how_many_readings_say_which_angles(count, first_deg, last_deg):
    first, step = flaser_angles(count)
    np.testing.assert_allclose(np.degrees([first, first + (count - 1) * step]), [first_deg, last_deg])


def test_robotlaser1(tmp_path):
    (scan,) = read_log(log(tmp_path, ROBOTLASER))
    assert (scan.angle_min_rad, scan.angle_increment_rad, scan.range_max_m) == (-1.0, 1.0, 30.0)
    assert scan.ranges_m.tolist() == [1.0, 2.0, math.inf]
    assert (scan.lidar_in_odom, scan.robot_in_odom) == ((0.5, 0.25, 0.1), (0.4, 0.2, 0.05))
    assert scan.stamp_s == 12.25


def test_odom(tmp_path):
    assert list(read_log(log(tmp_path, ODOM))) == [CarmenOdometry(976052857.3, (1.0, 2.0, 0.5), 0.75, -0.1)]


def test_range_max_may_be_given(tmp_path):
    scan, other = read_log(log(tmp_path, FLASER, ROBOTLASER), range_max_m=2.0)
    assert scan.ranges_m.tolist() == [1.0, math.inf, math.inf]
    assert other.range_max_m == 2.0


@given(st.floats(0.0, 2e9).map(lambda value: round(value, 6)), ranges, poses, poses, st.booleans())
def test_what_is_written_is_read_back(tmp_path_factory, stamp_s, ranges_m, robot, lidar, conventional):
    angles = flaser_angles(len(ranges_m)) if conventional else (-0.123456, 0.012345)
    scan = CarmenScan(stamp_s, np.array(ranges_m), *angles, 80.0, robot, lidar)
    odometry = CarmenOdometry(stamp_s, robot, *lidar[:2])
    line = format_scan(scan)
    assert line.startswith("FLASER" if conventional else "ROBOTLASER1")
    read, read_odometry = read_log(log(tmp_path_factory.getbasetemp(), line, format_odometry(odometry)))
    np.testing.assert_allclose(read.ranges_m, ranges_m, atol=1e-9)
    assert (read.stamp_s, read.robot_in_odom, read.lidar_in_odom) == (stamp_s, robot, lidar)
    np.testing.assert_allclose((read.angle_min_rad, read.angle_increment_rad), angles, atol=1e-6)
    assert read_odometry == odometry


def test_invalid_and_too_close_readings_are_zero():
    scan = CarmenScan(1.0, np.array([np.nan, -np.inf, 1.0]), 0.0, 0.1, 80.0, (0, 0, 0), (0, 0, 0))
    assert " 3 0.000 0.000 1.000 " in format_scan(scan)


@pytest.mark.table(
    "line",
    ["FLASER 3 1.0 2.0", "FLASER x", "FLASER", ROBOTLASER[:40], "ODOM 1 2 3", "ODOM nan 0 0 0 0 0 1 x 1"],
)
def test_a_broken_line_is_said_by_number(tmp_path, line):
    path = log(tmp_path, ODOM, line, ODOM)
    with pytest.raises(CarmenError, match=r"a\.log:5: "):
        list(read_log(path))
    said = []
    assert len(list(read_log(path, on_bad=said.append))) == 2
    assert f"{path}:5: " in str(said[0])


def test_a_reading_that_is_no_number_is_invalid_and_the_rest_of_the_scan_counts(tmp_path):
    (good,) = read_log(log(tmp_path, FLASER))
    (scan,) = read_log(log(tmp_path, FLASER.replace("2.50", "nan")))
    assert np.isnan(scan.ranges_m).sum() == 1
    kept = ~np.isnan(scan.ranges_m)
    np.testing.assert_array_equal(scan.ranges_m[kept], good.ranges_m[kept])


@pytest.mark.table(
    ("written", "meant"), [("1.#QNAN", math.nan), ("-1.#IND00", math.nan), ("1.#INF00", math.inf)]
)
def test_what_microsofts_compiler_writes_is_no_number_or_no_return(tmp_path, written, meant):
    (scan,) = read_log(log(tmp_path, FLASER.replace("2.50", written)))
    np.testing.assert_array_equal(scan.ranges_m, [1.0, meant, math.inf])


def test_a_robotlaser_without_range_or_increment_has_the_sicks_and_that_of_its_span(tmp_path):
    line = ROBOTLASER.replace("-1.0 2.0 1.0 30.0", "-1.0 2.0 0.0 0.0")
    (scan,) = read_log(log(tmp_path, line))
    assert (scan.range_max_m, scan.angle_increment_rad) == (80.0, 1.0)
    assert scan.ranges_m.tolist() == [1.0, 2.0, 31.0]


@pytest.mark.table("line", [FLASER, ROBOTLASER, ODOM])
def test_with_a_period_a_message_needs_no_stamp(tmp_path, line):
    bare = log(tmp_path, " ".join(line.split()[:-3]))
    (record,) = read_log(bare, period_s=0.5)
    (whole,) = read_log(log(tmp_path, line), period_s=0.5)
    assert record.robot_in_odom == whole.robot_in_odom


def test_scans_of_other_lidars_are_counted(tmp_path):
    other = ["RLASER 3 1 1 1", "ROBOTLASER2 0", "RAWLASER1 0", "PARAM laser_x 1", "RLASER", "SYNC x"]
    said = []
    assert len(list(read_log(log(tmp_path, FLASER, *other), on_other_lidar=said.append))) == 1
    assert said == ["RLASER", "ROBOTLASER2", "RAWLASER1", "RLASER"]


def test_any_byte_may_stand_in_a_comment(tmp_path):
    path = log(tmp_path, FLASER)
    path.write_bytes("# Universit\xe4t Freiburg\n".encode("latin-1") + path.read_bytes())
    assert len(list(read_log(path))) == 1


@pytest.mark.table("encoding", ["utf-16", "utf-8-sig"])
@pytest.mark.table("pack", [bytes, gzip.compress])
def test_a_log_that_an_editor_or_powershell_has_saved_is_the_same(tmp_path, encoding, pack):
    path = log(tmp_path, FLASER)
    (plain,) = read_log(path)
    path.write_bytes(pack(FLASER.encode(encoding)))
    (found,) = read_log(path)
    np.testing.assert_array_equal(found.ranges_m, plain.ranges_m)


@pytest.mark.table("content", [FLASER.encode("utf-16-le"), bytes(range(256))])
def test_what_is_no_text_is_refused(tmp_path, content):
    path = log(tmp_path, "")
    path.write_bytes(content)
    with pytest.raises(CarmenError, match="is not a text of CARMEN"):
        list(read_log(path))


def test_a_log_without_stamps_needs_its_period(tmp_path):
    path = log(tmp_path, *[FLASER] * 12)
    with pytest.raises(CarmenError, match=r"9 of the first 10 scans in .* do not ascend"):
        list(planar_scans(path))
    stamps_s = [scan.stamp_s for scan, _ in planar_scans(path, period_s=0.5)]
    np.testing.assert_allclose(stamps_s, 0.5 * np.arange(1, 13))


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(CarmenError, match=r"nothing\.log cannot be read: No such file or directory\.$"):
        list(read_log(tmp_path / "nothing.log"))
    (tmp_path / "a.log.gz").write_bytes(gzip.compress(FLASER.encode() * 100)[:-20])
    with pytest.raises(CarmenError, match="cannot be read"):
        list(read_log(tmp_path / "a.log.gz"))
    (tmp_path / "b.log.gz").write_text("not packed")
    with pytest.raises(CarmenError, match="cannot be read"):
        list(read_log(tmp_path / "b.log.gz"))


@pytest.mark.skipif(not INTEL.exists(), reason=f"needs {INTEL}")
def test_the_intel_log():
    scans = list(read_log(INTEL))
    assert len(scans) == 910
    assert all(scan.ranges_m.size == 180 for scan in scans)
    stamps_s = [scan.stamp_s for scan in scans]
    assert (stamps_s[0], stamps_s[-1]) == (976052890.244111, 976055541.103089)


@pytest.mark.table("farthest_m", [5.0, 100.0])
def test_a_lidar_without_a_greatest_range_is_written_in_numbers(tmp_path, farthest_m):
    ranges_m = np.array([farthest_m, np.inf, 1.0, np.nan])
    scan = CarmenScan(1.0, ranges_m, -1.0, 0.1, np.inf, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    line = format_scan(scan)
    assert "inf" not in line
    (back,) = read_log(log(tmp_path, line))
    np.testing.assert_allclose(back.ranges_m, [farthest_m, np.inf, 1.0, 0.0])
