"""Given readings of thickness, they stand beside the plates, and a bad row is refused."""

import pytest
from drawn_inspection import ship

from inspection_tools.errors import ReportError
from inspection_tools.report.spots import COLUMNS, Gauging, with_readings

HEAD = ",".join(COLUMNS) + "\n"


def test_readings_join_the_plates_and_add_others(tmp_path):
    path = tmp_path / "readings.csv"
    path.write_text(HEAD + "1,A,P,12.0,10.0,11.0,pitted\n4, B, S, 12.0, , 11.4,\n")
    proposed = next(each for each in ship().plates() if each.text == "Fr. 0 to 4, strake A, P")
    first, added = with_readings([Gauging(proposed, "rust")], ship(), path)
    assert (first.why, first.remark, added.why) == ("rust", "pitted", "measured")
    assert (first.diminution_mm, first.diminution_share) == pytest.approx((1.5, 0.125))
    assert added.diminution_mm == pytest.approx(0.6)
    assert added.plate.text == "Fr. 4 to 8, strake B, S"
    assert Gauging(proposed, "rust").diminution_mm is None


@pytest.mark.parametrize(
    "row", ["1,A,X,12,11,11,", "99,A,P,12,11,11,", "1,Z,P,12,11,11,", "1,A,P,thick,11,11,", "1,A,P,nan,1,1,"]
)
def test_a_bad_reading_is_named_by_its_line(tmp_path, row):
    path = tmp_path / "readings.csv"
    path.write_text(HEAD + row + "\n")
    with pytest.raises(ReportError, match="line 2"):
        with_readings([], ship(), path)
