"""Whatever is wrong in a file that comes from outside is told in one sentence that names file and key.

For each key of each schema: the key is missing, or its value is of another type, or no number. Where a file
is read without what is wrong in it, only that is left out.
"""

import copy
import dataclasses
import hashlib
import json
from typing import Any, Callable, Literal, NamedTuple, get_args, get_origin, get_type_hints

import pytest
import yaml

from flight_basics.errors import FlightBasicsError, ReportError
from flight_limits.limits import LimitsError, LimitsFile, read_limits
from flights.campaign.reading import read_campaign
from flights.errors import FlightsError
from input_schemas import MaybeInfinite, read_without
from inspection.files.coverage_record import CoverageRecord
from inspection.files.run_record import RunRecord
from inspection.findings.findings_file import FindingsFile, read_search
from inspection.findings.remembered import MarksFile, read_marks
from inspection.photographs.record import PhotographRecord, read_record
from inspection.ship.ship_file import ShipFile, read_ship
from inspection.survey.plan_file import PlanFile, read_plan
from inspection_tools.mission.file import MissionFile, read_mission
from simulation_tools.camera.defects import DefectFile, read_defects
from simulation_tools.camera.effects.amounts import Effects
from simulation_tools.camera.errors import PhotographError as CameraError

PLACE, BOX = [1.0, 2.0, 3.0], {"low": [0.0, 0.0, 0.0], "high": [1.0, 1.0, 1.0], "name": "a"}
LENS = {"focal_px": [100.0, 100.0], "centre_px": [31.5, 23.5], "distortion": [0.0] * 8}
CAMERA = {
    "width": 64, "height": 48, "field_of_view": 60.0, "tilt_min": -90.0, "tilt_max": 90.0, "exposure": 1e-3,
    "lens": LENS,
}  # fmt: skip
ASKED = {
    "resolution": 1.0, "incidence": 60.0, "share": 0.98, "class_share": 0.95, "patch": 0.25, "voxel": 0.1,
    "spacing": 0.0, "radius": 0.35, "margin": 0.15, "comfort": 0.0, "pointing_error": 0.5, "finer": 0.0,
    "around": 0.0, "outside": False, "planning": "greedy",
}  # fmt: skip
FLYING = {
    "speed": 1.5, "acceleration": 1.0, "passing": False, "passing_speed": 0.5, "settle": 0.1, "mass": 2.27,
    "yaw_rate": 90.0, "tilt_rate": 60.0, "battery": 56.6, "electronics": 40.5, "endurance": 900.0,
    "reserve": 0.12, "way_home_margin": 1.3, "landing_time": 10.0,
}  # fmt: skip
PLAN = {
    "source": "tank.dae", "home": PLACE, "camera": CAMERA, "asked": ASKED, "flying": FLYING,
    "figures": {"share": 0.9}, "shares": {"shell": 0.9}, "draft": {"seed": 1, "search_s": 2.0},
    "left_out": [{"part": "shell", "why": "hidden", "area_m2": 1.0, "at": PLACE}],
    "flights": [
        {
            "time_s": 9.0,
            "way_m": 8.0,
            "photographs": [{"id": 1, "at": PLACE, "yaw": 5.0, "tilt": 1.0, "way": [PLACE]}],
        }
    ],
}  # fmt: skip
SHIP = {
    "name": "a", "space": "b", "ap": PLACE, "heading": 0.0, "plate_frames": 5, "parts": {"shell": "Shell"},
    "frames": [{"from": 0, "to": 10, "spacing": 600, "at": 0.0}], "particulars": {"imo": "1"},
    "strakes": [{"name": "A", "breadth": [0.0, 2.0], "height": [0.0, 2.0]}],
    "areas": [{"name": "low", "frames": [0, 10], "sides": ["P"], "strakes": ["A"], "parts": ["shell"]}],
}  # fmt: skip
MISSION = {
    "tolerance": 0.5, "hold": 1.0, "laps": 2,
    "waypoints": [{"x": 1.0, "y": 2.0, "z": 3.0, "yaw": 0.0, "tolerance": 0.2, "hold": 0.0}],
}  # fmt: skip
LIMITS = {"ceiling": 9.0, "keep_out": [BOX], "keep_in": BOX}
FINDING = {
    "id": 1, "kind": "rust", "position_m": PLACE, "normal": PLACE, "length_m": 1.0, "area_m2": 1.0,
    "photographs": ["1.jpg"], "status": "new", "remark": "a", "detail_mm": 1.0, "places_m": [PLACE],
    "deviation_m": 0.1,
}  # fmt: skip
LEFT_OUT = {"photograph": "2.jpg", "why": "blurred"}
PICTURE_MARK = {"kind": "rust", "box_px": [1, 2, 3, 4], "size_px": 5}
FINDINGS = {
    "findings": [FINDING], "searched": ["1.jpg"], "left_out": [LEFT_OUT], "red": ["1.jpg"],
    "flawed": [LEFT_OUT], "without_pose": [{"photograph": "3.jpg", "marks": [PICTURE_MARK]}],
    "rests_on": {"1.jpg": "0"},
}  # fmt: skip
MARKS = {
    "photograph": hashlib.sha256(b"").hexdigest(),
    "candidates": [{"kind": "rust", "pixels": [[1.0, 2.0]], "size_px": 3}],
}
TURN = [0.0, 0.0, 0.0, 1.0]
RECORD = {
    "stamp_s": 1.0, "position_m": PLACE, "orientation_xyzw": TURN, "exposure_s": 0.1, "iso": 1.0, "lux": 1.0,
    "blur_px": 0.1, "covariance": [0.0] * 36, "patches": [1], "view": 1, "shift_m": 0.0, "turn_rad": 0.0,
    "viewpoint": [0.0] * 5, "told_position_m": PLACE, "told_orientation_xyzw": TURN,
    "source": "SLAM",
}  # fmt: skip
MARK = {
    "kind": "rust", "position_m": PLACE, "normal": PLACE, "along": PLACE, "length_m": 1.0, "width_m": 1.0,
    "seed": 1,
}  # fmt: skip
EFFECTS = {each.name: 1 for each in dataclasses.fields(Effects)}
DEFECTS = {"defects": [MARK], "coatings": {"shell": PLACE}, "effects": EFFECTS, "world": "a", "seed": 1}
COVERAGE = {
    "surface": "a.dae", "counted": ["1.jpg"], "resolution_mm_per_px": 1.0, "incidence_deg": 60.0,
    "mesh_m2": 1.0, "reachable_m2": 1.0, "share_of_reachable": 0.5, "record": "0", "rests_on": {"1.jpg": "0"},
    "of": "map", "drawing": {
        "surface": "b.world", "surface_m2": 3.0, "reachable_m2": 2.0, "shown_m2": 1.0,
        "share_of_reachable": 0.5, "not_mapped_m2": 1.0,
        "classes": {"web": {"reachable_m2": 1.0, "share": 0.5, "not_mapped_m2": 1.0}},
    },
}  # fmt: skip
FLOWN = {
    "photographs": 3, "purpose": "a", "time_s": 1.0, "way_m": 1.0, "battery_start": 1.0, "battery_end": 0.5
}  # fmt: skip
RUN = {
    "flights": [FLOWN], "touched": ["shell"], "failure": "a", "date": "b", "world": "c", "seed": "1",
    "exploration": {"known_m3": 1.0, "home_s": 1.0, "unknown": [{"border_m2": 1.0, "why": "dark"}]},
    "inspection": {
        "taken": 1, "asked": 2, "shots": 3, "swaps": 0, "flight_s": 9.0, "reason": "done",
        "left_out": [{"photograph": 2, "why": "no way"}],
    },
    "commit": "d", "versions": {"numpy": "1"},
}  # fmt: skip


class Case(NamedTuple):
    """A kind of file. is_lenient: `read` returns what it holds and sentences on what it leaves out."""

    name: str
    read: Callable[[Any], Any]
    schema: Any
    good: dict
    is_lenient: bool = False


def marks_beside(path):
    path.with_name("a.jpg").touch()
    return read_marks(path.with_name("a.jpg"))


def without(schema):
    return lambda path: read_without(path, "The record", schema, ReportError)


CASES = [
    Case("plan.yaml", read_plan, PlanFile, PLAN),
    Case("ship.yaml", read_ship, ShipFile, SHIP),
    Case("mission.yaml", read_mission, MissionFile, MISSION),
    Case("limits.yaml", read_limits, LimitsFile, LIMITS),
    Case("a.defects.yaml", read_defects, DefectFile, DEFECTS),
    Case("findings.json", read_search, FindingsFile, FINDINGS),
    Case("a.marks.json", marks_beside, MarksFile, MARKS),
    Case("1.json", read_record, PhotographRecord, RECORD),
    Case("coverage.json", without(CoverageRecord), CoverageRecord, COVERAGE, True),
    Case("result.json", without(RunRecord), RunRecord, RUN, True),
]
WRONG = {
    float: ["x", True, float("nan"), float("inf"), [1.0], {}, 10**400],
    MaybeInfinite: ["x", True, float("nan"), [1.0], {}],
    int: ["x", True, 1.5, float("nan"), [1], {}],
    str: [True, ["x"], {}],
    bool: ["yes", 1],
}
"""By type, values that it may not be made of."""


def keys_in(schema: Any, content: Any, way: tuple = ()) -> Any:
    """Yield the way to each value of the content, its type, and whether it must be there."""
    hints = get_type_hints(schema)
    for field in dataclasses.fields(schema):
        key = field.name.rstrip("_")
        assert key in content, f"the table lacks {key} of {schema.__name__}"
        missing = dataclasses.MISSING
        is_needed = field.default is missing and field.default_factory is missing
        yield from values_in(hints[field.name], content[key], (*way, key), is_needed)


def values_in(kind: Any, content: Any, way: tuple, is_needed: bool) -> Any:
    if type(None) in get_args(kind):
        (kind,) = (each for each in get_args(kind) if each is not type(None))
    yield way, kind, is_needed
    if dataclasses.is_dataclass(kind):
        yield from keys_in(kind, content, way)
    elif get_origin(kind) is dict:
        key = next(iter(content))
        yield from values_in(get_args(kind)[1], content[key], (*way, key), False)
    elif get_args(kind)[1:] == (...,):
        yield from values_in(get_args(kind)[0], content[0], (*way, 0), False)


def wrong_values(kind: Any) -> list:
    if get_origin(kind) is Literal:
        return ["zz", 3, ["new"]]
    if kind is Any:
        return []
    if dataclasses.is_dataclass(kind) or get_origin(kind) is dict:
        return ["x", 3, ["x"]]
    return WRONG.get(kind) or ["x", 3, {"a": 1}] + (
        [] if get_args(kind)[1:] == (...,) else [[1.0], ["x"] * 9]
    )


def written(path, content):
    path.write_text(json.dumps(content) if path.suffix == ".json" else yaml.safe_dump(content))
    return path


ERRORS = FlightBasicsError, LimitsError, FlightsError, CameraError


def told_of(case, path):
    """Return the sentence with which a file is refused, or those on what is left out of it; empty: none."""
    try:
        held = case.read(path)
    except ERRORS as error:
        return str(error)
    return " ".join(held[1]) if case.is_lenient else ""


def changed(content, way, value=None, is_lost=False):
    content = copy.deepcopy(content)
    holder = content
    for key in way[:-1]:
        holder = holder[key]
    if is_lost:
        del holder[way[-1]]
    else:
        holder[way[-1]] = value
    return content


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_each_key_that_is_lost_or_wrong_is_named(case, tmp_path):
    path = tmp_path / case.name
    assert not told_of(case, written(path, case.good))
    for way, kind, is_needed in keys_in(case.schema, case.good):
        name = next(key for key in reversed(way) if isinstance(key, str))
        faults = [changed(case.good, way, value) for value in wrong_values(kind)]
        if is_needed and way != ("stamp_s",):  # the name of the photograph's file has it
            faults += [changed(case.good, way, is_lost=True), changed(case.good, way, None)]
        for content in faults:
            told = told_of(case, written(path, content))
            assert case.name in told, (way, told)
            assert name in told, (way, told)
            assert "\n" not in told
            assert len(told) < 400


@pytest.mark.parametrize("case", [each for each in CASES if each.name.endswith("yaml")], ids=lambda c: c.name)
def test_a_key_that_is_unknown_is_named_where_people_write_the_file(case, tmp_path):
    path = tmp_path / case.name
    parts = [way for way, kind, _ in keys_in(case.schema, case.good) if dataclasses.is_dataclass(kind)]
    for way in [(), *parts]:
        told = told_of(case, written(path, changed(case.good, (*way, "zz"), 1)))
        assert case.name in told, way
        assert "'zz'" in told, way


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_file_that_is_cut_or_something_else_is_refused(case, tmp_path):
    path = tmp_path / case.name
    whole = written(path, case.good).read_bytes()
    for text in (b"", b"3", b"null", b'"x"', b"[3]", b"{", b"[" * 1000, b"\0\1"):
        path.write_bytes(text)
        told = told_of(case, path)
        assert case.name in told, text
        assert "\n" not in told
    path.write_bytes(whole[: len(whole) // 2])
    assert (case.name in told_of(case, path)) or path.suffix == ".yaml"  # it may end anywhere


def test_a_tab_is_told_with_its_line(tmp_path):
    path = tmp_path / "campaign.yaml"
    path.write_text("kind: flight\ntrials:\n\tworld: room\n")
    for read in (read_campaign, read_limits, read_plan, read_ship, read_mission):
        with pytest.raises(
            ERRORS, match=r"campaign\.yaml cannot be read: line 3, column 1 is not YAML .a tab"
        ):
            read(path)
