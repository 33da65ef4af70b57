"""Given a ship's frames and strakes, places of the map are named as a surveyor names them."""

import copy

import numpy as np
import pytest
import yaml

from flight_basics.errors import ShipError
from inspection.ship.ship import Ship
from inspection.ship.ship_file import parse_ship, read_ship

SHIP = {
    "name": "Test",
    "ap": [-10.0, 0.0, -1.0],
    "frames": [{"from": 0, "to": 10, "spacing": 600}, {"from": 10, "to": 30, "spacing": 800}],
    "plate_frames": 5,
    "strakes": [{"name": "A", "height": [0, 2]}, {"name": "B", "height": [2, 5]}],
    "areas": [
        {"name": "low", "strakes": ["A"]},
        {"name": "port", "strakes": ["B"], "sides": ["P"], "frames": [0, 10]},
        {"name": "walls", "strakes": ["B"], "sides": ["S"], "parts": ["shell"]},
    ],
}


def test_a_place_is_told_by_frame_strake_and_side():
    ship = parse_ship(SHIP)
    # frame 12 stands 10 * 0.6 + 2 * 0.8 = 7.6 m forward of the AP, so at x = -2.4 m of the map
    assert ship.describe((-2.1, -4.0, 0.5)) == "Fr. 12 + 300, strake A, S"
    assert ship.describe((-2.4, 4.0, 1.5)) == "Fr. 12, strake B, P"
    assert ship.describe((-10.2, 0.0, 9.0)) == "Fr. 0 \N{MINUS SIGN} 200, CL"
    assert Ship().describe((1.0, 2.0, 3.0)) == "x 1.00, y 2.00, z 3.00 m"


def test_things_of_the_mesh_have_a_surveyors_words():
    ship = parse_ship({**SHIP, "parts": {"ground_plane": "tank top"}})
    assert [ship.part(each) for each in ("ground_plane", "deck_beams")] == ["tank top", "deck beams"]
    names = ("mapped_plating", "mapped_structure", "mapped_bars", "unknown")
    assert [ship.part(each) for each in names] == [
        "plating",
        "structure",
        "ladders, gratings",
        "not surveyed",
    ]


def test_a_ship_that_is_turned_in_the_map_tells_the_same_places():
    ship = parse_ship({**SHIP, "ap": [0.0, -10.0, -1.0], "heading": 90.0})
    assert ship.describe((4.0, -2.1, 0.5)) == "Fr. 12 + 300, strake A, S"


def test_plates_and_areas_hold_the_places_in_them():
    ship = parse_ship(SHIP)
    points = np.array(
        ((-9.9, 3.0, 0.0), (-4.0, -3.0, 2.0), (12.0, 3.0, 0.0), (14.0, 3.0, 0.0), (0.0, 3.0, 6.0))
    )
    plates, of = ship.plates(), ship.plates_of(points)
    names = [plates[k].text if k >= 0 else None for k in of]
    first, second, last = "Fr. 0 to 5, strake A, P", "Fr. 10 to 15, strake B, S", "Fr. 25 to 30, strake A, P"
    assert names == [first, second, last, None, None]
    assert ship.areas_of(points[:2], ["shell", "deck"]).tolist() == [0, -1]
    assert ship.areas_of(points[1:2], ["shell"]).tolist() == [2]
    assert ship.areas_of(np.array(((-9.0, 1.0, 2.0), (0.0, 1.0, 2.0))), ["", ""]).tolist() == [1, -1]


@pytest.mark.table("off_m", [0.0, 0.07, -0.07, 0.14])
def test_a_wall_of_a_map_that_lies_off_its_drawing_stays_in_its_area_and_plate(off_m):
    """A hold of Fr. 0 to 10, 6 m long, 8 m wide, 5 m high; its six walls are moved outwards by off_m."""
    walls = {"aft": "V", "forward": "V", "port": "A", "starboard": "A", "floor": "T", "deck": "D"}
    ship = parse_ship(
        {
            "frames": [{"from": 0, "to": 10, "spacing": 600}], "plate_frames": 10,
            "strakes": [
                {"name": "T", "breadth": [0, 4], "height": [0, 0.5]},
                {"name": "V", "breadth": [0, 3.5], "height": [0.5, 4.5]},
                {"name": "A", "breadth": [3.5, 4], "height": [0.5, 4.5]},
                {"name": "D", "breadth": [0, 4], "height": [4.5, 5]},
            ],
            "areas": [
                {"name": "aft", "frames": [0, 1], "strakes": ["V"]},
                {"name": "forward", "frames": [9, 10], "strakes": ["V"]},
                {"name": "port", "strakes": ["A"], "sides": ["P"]},
                {"name": "starboard", "strakes": ["A"], "sides": ["S"]},
                {"name": "floor", "strakes": ["T"]}, {"name": "deck", "strakes": ["D"]},
            ],
        }
    )  # fmt: skip
    points = np.array(
        [
            (-off_m, 1.0, 2.0), (6.0 + off_m, 1.0, 2.0), (3.0, 4.0 + off_m, 2.0), (3.0, -4.0 - off_m, 2.0),
            (3.0, 1.0, -off_m), (3.0, 1.0, 5.0 + off_m),
        ]
    )  # fmt: skip
    inwards = np.array(((1, 0, 0), (-1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1)), float)
    assert ship.areas_of(points, [None] * 6, inwards).tolist() == list(range(6))
    assert [ship.plates()[k].strake for k in ship.plates_of(points, inwards)] == list(walls.values())
    assert [
        "strake " + strake in ship.describe(*each) for strake, *each in zip(walls.values(), points, inwards)
    ] == [True] * 6
    assert ship.areas_of(points - 0.5 * inwards, [None] * 6, inwards).tolist() == [-1] * 6


def test_what_lies_beside_a_strake_in_the_plane_of_a_wall_does_not_belong_to_it():
    ship = parse_ship(
        {
            "frames": [{"from": 0, "to": 10, "spacing": 600}],
            "strakes": [{"name": "V", "height": [0.3, 3.5]}],
            "areas": [{"name": "wall", "strakes": ["V"]}],
        }
    )  # fmt: skip
    places = np.array(((0.0, 1.0, 0.29), (0.0, 1.0, 0.31)))
    assert ship.areas_of(places, [None] * 2, np.tile((1.0, 0.0, 0.0), (2, 1))).tolist() == [-1, 0]


def test_a_bulkhead_on_the_centre_line_stays_on_the_side_of_its_area():
    ship = parse_ship(
        {
            "frames": [{"from": 0, "to": 10, "spacing": 600}],
            "areas": [{"name": "centre line", "sides": ["P"]}],
        }
    )
    places = np.array(((3.0, -0.07, 2.0), (3.0, -0.5, 2.0)))
    assert ship.areas_of(places, [None] * 2, np.tile((0.0, -1.0, 0.0), (2, 1))).tolist() == [0, -1]


@pytest.mark.table(
    ("path", "value", "told"),
    [
        (("frames", 1, "from"), 8, "overlap"),
        (("frames", 1, "from"), 12, "gap"),
        (("frames", 0, "from"), 3, "at: the distance of frame 3"),
        (("frames", 0, "spacing"), 0, "spacing above 0"),
        (("frames", 1, "at"), 5.0, "already stands at 6 m"),
        (("frames",), [], "frames is empty"),
        (("strakes", 1, "height"), [1, 5], "A and B overlap"),
        (("strakes", 1, "name"), "A", "two strakes"),
        (("strakes", 1, "height"), [5, 2], "the lower first"),
        (("areas", 1, "strakes"), ["C"], "strake C, which is unknown"),
        (("areas", 1, "frames"), [0, 99], "give two from 0 to 30"),
        (("areas", 1, "sides"), ["X"], "P, S or both"),
        (("areas", 2, "sides"), ["P"], '"port" and "walls" overlap'),
        (("plate_frames",), 0, "plate_frames"),
    ],
)
def test_a_ship_that_makes_no_sense_is_refused_in_one_sentence(path, value, told):
    ship = copy.deepcopy(SHIP)
    held = ship
    for key in path[:-1]:
        held = held[key]
    held[path[-1]] = value
    with pytest.raises(ShipError) as refused:
        parse_ship(ship)
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_file_of_a_ship_is_read(tmp_path):
    (tmp_path / "good.yaml").write_text(yaml.safe_dump(SHIP))
    assert read_ship(tmp_path / "good.yaml") == parse_ship(SHIP)
