"""Given what an inspection told, its headline."""

import pytest

from flights.inspecting.summary import headline

TOLD = {"end": "", "reason": "-", "asked": 9, "taken": 4, "closer": 1, "open": 5, "shots": 6, "left_out": []}
RUN = {
    "scenario": "hold_3d", "algorithm": "dynamic", "lidar": "puck", "seed": 1, "reached_goal": False,
    "collision": False, "failure": "interrupted",
    **dict.fromkeys(("flight_time_s", "path_length_m", "min_clearance_m", "real_time_factor")),
    **dict.fromkeys(("cepa_computation_ms", "latency_ms")),
}  # fmt: skip


@pytest.mark.table(("stored", "says"), [(5, False), (7, True)])
def test_photographs_of_an_interrupted_flight_are_told(stored, says):
    told = {**TOLD, "swaps": 0, "flight_s": 60.0, "stored": stored}
    words = headline({**RUN, "inspection": told})
    assert "4 of 9 taken" in words
    assert ("stored" in words and "7 photographs" in words) == says


def test_photographs_of_an_interrupted_first_flight_are_told():
    words = headline({**RUN, "inspection": {"end": "", "reason": "no result", "stored": 2}})
    assert "2 photographs" in words
