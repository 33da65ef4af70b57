"""Given the record of the flights, the page tells what was asked for, and has no column without a value."""

from types import SimpleNamespace

from drawn_inspection import folder, side_walls
from page_words import words

from inspection.files.run_record import FlownFlight, RunRecord, Surveyed
from inspection.report.command import main
from inspection.report.records import flights
from inspection.report.tables import unseen_tables
from inspection.ship.ship import Ship


def test_fewer_photographs_than_planned_are_told():
    plan = SimpleNamespace(views=(None,) * 40, flights=())
    record = SimpleNamespace(result=RunRecord(inspection=Surveyed(taken=8, asked=8)), plan=plan)
    told = " ".join(flights(record)["told"])
    assert "8 of 8 photographs were taken. Only 8 of the plan's 40 photographs were asked for." in told
    record.result = RunRecord(inspection=Surveyed(taken=38, asked=40))
    assert "Only" not in " ".join(flights(record)["told"])


def test_a_column_without_a_value_is_left_out(tmp_path):
    flown = FlownFlight([1, 2], time_s=60.0, battery_start=1.0, battery_end=0.8)
    found = flights(SimpleNamespace(result=RunRecord((flown,)), plan=None))
    assert found["has"] == {"time_min": True, "way_m": False, "battery_start": True, "battery_end": True}
    path = folder(tmp_path / "all")
    assert main([str(path)]) == 0
    told = words(path / "report.html")
    assert "Battery at the start" in told
    assert ("Way, m" in told) == ('"way_m"' in (path / "result.json").read_text())


def test_what_lies_on_no_plate_is_told_with_the_reason():
    surface = side_walls(lambda points: points[:, 0] > 0.0)
    rows = unseen_tables(SimpleNamespace(surface=surface, coverage=None, plan=None, result=None), Ship())[
        "open"
    ]
    assert [row["place"] for row in rows] == ["the whole space: no ship's file divides it into plates"]
