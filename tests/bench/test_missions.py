"""What the campaigns of missions on small batteries count."""

from __future__ import annotations

from benchmarks.inspection_rows import missions

GOOD = {
    "contact": False,
    "landed": True,
    "failure": "",
    "off_home_m": 0.2,
    "landed_at": [0.13, 0.94],
    "asked": 30,
    "taken": 28,
    "left_out": 1,
    "open": 1,
}


def test_good_missions_count_as_good():
    told = missions.summary([GOOD, GOOD])
    assert (told["missions"], told["landings"], told["least_charge"]) == (2, 4, 0.13)
    assert (told["asked"], told["taken"], told["left_out"], told["open"]) == (60, 56, 2, 2)
    assert [told[key] for key in ("below_goal", "contacts", "not_home", "lost")] == [0, 0, 0, 0]


def test_each_fault_is_counted():
    low = {**GOOD, "landed_at": [0.099]}
    far, touched = {**GOOD, "off_home_m": 1.1}, {**GOOD, "contact": True}
    still_flying, failed = {**GOOD, "landed": False, "landed_at": []}, {**GOOD, "failure": "lost"}
    without = {**GOOD, "taken": 27}
    told = missions.summary([GOOD, low, far, touched, still_flying, failed, without])
    assert [told[key] for key in ("below_goal", "contacts", "not_home", "lost")] == [1, 1, 3, 1]
    assert told["least_charge"] == 0.099
