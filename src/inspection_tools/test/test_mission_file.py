"""What the file of a mission may say."""

import pytest

from flight_basics.errors import MissionError
from inspection_tools import Waypoint, parse_mission, read_mission


def test_a_file_in_every_form(tmp_path):
    path = tmp_path / "mission.yaml"
    path.write_text(
        "tolerance: 0.5\n"
        "waypoints:\n"
        "  - 1 2 3\n"
        "  - [4, 5, 6, 0.5]\n"
        "  - {x: 7, y: 8.5, z: 9, tolerance: 0.1, hold: 3}\n"
    )
    assert read_mission(path) == (
        Waypoint((1.0, 2.0, 3.0), tolerance_m=0.5),
        Waypoint((4.0, 5.0, 6.0), 0.5, tolerance_m=0.5),
        Waypoint((7, 8.5, 9), tolerance_m=0.1, hold_s=3),
    )
    assert parse_mission([[1, 2, 3]]) == (Waypoint((1.0, 2.0, 3.0)),)
    a, b = Waypoint((1.0, 2.0, 3.0)), Waypoint((4.0, 5.0, 6.0))
    assert parse_mission({"waypoints": ["1 2 3", "4 5 6"], "laps": 2}) == (a, b, a, b)


@pytest.mark.table(
    ("content", "words"),
    [
        (None, "no waypoints; give a list"),
        ([], "no waypoints; give a list"),
        ("1 2 3", "no waypoints; give a list"),
        ({"waypoints": {"x": 1}}, "no waypoints; give a list"),
        ({"waypoints": ["1 2 3"], "laps": 0}, "laps is 0; it must be a whole number from 1 to 1000"),
        (["1 2 3", "1 2"], "entry 2 of waypoints lacks the key 'z'"),
        (["1 2 up"], "z in entry 1 of waypoints is 'up'"),
        (["1 nan 3"], "y in entry 1 of waypoints is nan"),
        ([[1, 2, 3, 4, 5]], "entry 1 of waypoints is"),
        ([[1, 2, 1e9]], "entry 1 of waypoints: z is"),
    ],
)
def test_a_mission_that_makes_no_sense_is_one_sentence(content, words):
    with pytest.raises(MissionError) as error:
        parse_mission(content)
    assert words in str(error.value)


def test_a_file_that_makes_no_sense_is_named_with_its_line(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text("- 1 2 3\n- 1 2 up\n")
    with pytest.raises(MissionError, match=r"bad\.yaml, line 2: z in entry 2"):
        read_mission(path)
