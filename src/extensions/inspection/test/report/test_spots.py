"""Given readings of thickness, all stay beside their plates, the least is official, a bad row is refused."""

import pytest
from drawn_inspection import SHIP, ship

from flight_basics.errors import ReportError
from inspection.report.gauging.readings import HEADS, read_readings
from inspection.report.gauging.spots import Gauging, with_readings
from inspection.ship.ship_file import parse_ship

HEAD = ",".join(HEADS) + "\n"


def told(path, text, spots=(), of=None, encoding="utf-8"):
    """The plates with the readings of a table."""
    path.write_text(text, encoding=encoding)
    return with_readings(spots, read_readings(path, of or ship()).rows)


def test_readings_join_the_plates_and_add_others(tmp_path):
    proposed = next(each for each in ship().plates() if each.text == "Fr. 0 to 4, strake A, P")
    text = HEAD + "1,A,P,12.0,10.0,11.0,pitted\n4, B, S, 12.0, , 11.4,\n"
    first, added = told(tmp_path / "readings.csv", text, [Gauging(proposed, "rust")])
    (row,), (other,) = first.rows(), added.rows()
    assert (row.why, row.remark, other.why) == ("rust", "pitted", "measured")
    assert (row.lost_mm, row.lost) == pytest.approx(
        (2.0, 2.0 / 12.0)
    )  # of the lower reading, not of their mean
    assert other.lost_mm == pytest.approx(0.6)
    assert other.plate == "Fr. 4 to 8, strake B, S"
    (empty,) = Gauging(proposed, "rust").rows()
    assert (empty.lost_mm, empty.forward_mm) == (None, None)


def test_all_rows_of_a_plate_are_kept_and_the_least_is_official(tmp_path):
    text = HEAD + "1,A,P,14.0,9.0,9.7,worst pit\n3,A,P,,13.9,13.8,\n2,A,P,14.0,,12.0,\n"
    (plate,) = told(tmp_path / "readings.csv", text)
    rows = plate.rows()
    assert [(row.frame, row.forward_mm, row.aft_mm) for row in rows] == [
        ("1", 9.0, 9.7), ("3", 13.9, 13.8), ("2", None, 12.0),
    ]  # fmt: skip
    assert [row.is_least for row in rows] == [True, False, False]
    assert [row.lost_mm for row in rows] == pytest.approx([5.0, 0.2, 2.0])


@pytest.mark.table(
    ("original", "reading", "lost"), [("14", "14.2", 0.0), ("3.1", "13.2", None), ("", "13.2", None)]
)
def test_no_plate_grows(tmp_path, original, reading, lost):
    (plate,) = told(tmp_path / "readings.csv", HEAD + f"1,A,P,{original},{reading},,\n")
    (row,) = plate.rows()
    assert (row.lost_mm, row.lost) == (lost, lost)
    assert ("check" in row.remark) == (original == "3.1")


@pytest.mark.table(
    "text",
    [
        "frame,strake,side,original,forward,aft\n1,A,P,14.0,9.1,9.7\n",
        "\ufeffFrame;Strake;Side;Original (mm);Fwd. [mm];Aft\n1;A;PORT;14,0;9,1;9,7\n",
        "frame\tstrake\tside\toriginal_mm\tforward_mm\taft_mm\n1.0\tA\tport\t14.0\t9.1 mm\t9.7\n",
        'sep=;\n"Frame";"Strake";"Side";"Original, mm";"Forward";"Aft"\n1;A;"Port";"14,0";"9,1";9,7\n',
        '"Frame","Strake","Side","Original\n; (mm)","Forward","Aft"\n"1","A","P","14,0","9,1","9,7"\n',
        "# gauged on Monday\n\nframe|strake|side|original|forward|aft\n\n Fr. 1 | a | p | 14.0 | 9.1 | 9.7\n",
    ],
)
@pytest.mark.table("encoding", ["utf-8", "utf-16", "cp1252"])
def test_tables_of_other_programs_are_read(tmp_path, text, encoding):
    if encoding == "cp1252":
        text = text.lstrip("\ufeff")
    (plate,) = told(tmp_path / "readings.csv", text, encoding=encoding)
    (row,) = plate.rows()
    assert (row.plate, row.forward_mm, row.aft_mm) == ("Fr. 0 to 4, strake A, P", 9.1, 9.7)
    assert row.lost == pytest.approx(4.9 / 14.0)


def test_a_frame_aft_of_the_perpendicular_has_its_plate(tmp_path):
    aft = parse_ship({**SHIP, "frames": [{"from": -4, "to": 4, "spacing": 500, "at": -2.0}]})
    (plate,) = told(tmp_path / "readings.csv", HEAD + "-3,A,P,12,11,11,\n", of=aft)
    assert plate.plate.text == "Fr. -4 to 0, strake A, P"


@pytest.mark.table(
    "row",
    [
        "1,A,X,12,11,11,", "99,A,P,12,11,11,", "1,Z,P,12,11,11,", "1,A,P,thick,11,11,", "1,A,P,nan,1,1,",
        "\u00b2,A,P,14,9.1,9.7,", "1.5,A,P,14,9.1,9.7,", "1,A,P,14,,,lost", "1,A,P,14,0,9,1,7,,",
        "1,A,P,1e3,9,9,",
    ],
)  # fmt: skip
def test_a_bad_reading_is_named_by_its_line(tmp_path, row):
    with pytest.raises(ReportError, match="line 2"):
        told(tmp_path / "readings.csv", HEAD + row + "\n")


@pytest.mark.table(
    "text", ["", HEAD, "frame,strake,original_mm\n1,A,12\n", "frame,strake,side,fwd,forward\n", "\0\0\0"]
)
def test_a_table_without_readings_is_refused(tmp_path, text):
    with pytest.raises(ReportError, match=r"readings\.csv"):
        told(tmp_path / "readings.csv", text)
