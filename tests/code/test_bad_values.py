"""Each value that a parameter's field does not allow is refused in one sentence, which names the field.

The limits are those of the fields (`limited`), so this holds for every class of every package. `MISFITS` are
values that each field allows, but not beside the others, and values of fields that are no single number.
"""

from __future__ import annotations

import dataclasses
import importlib
import math
from pathlib import Path
from typing import Any, Iterator

import pytest

ROOT = Path(__file__).resolve().parents[2]
NEEDED: dict[str, dict[str, Any]] = {
    "AirStream": {"mean_m_s": 1.0},
    "BatteryParameters": {"capacity_ah": 5.0, "initial_charge_ah": 0.0},
    "CalibrationFile": {"image_width": 1, "image_height": 1, "camera_matrix": None},
    "Campaign": {"name": "c", "kind": "trials", "blocks": (), "seed": 1, "seeds": 1},
    "Defect": {
        "kind": "rust",
        "position_m": (0.0, 0.0, 0.0),
        "normal": (0.0, 0.0, 1.0),
        "along": (1.0, 0.0, 0.0),
        "length_m": 1.0,
        "width_m": 1.0,
    },
    "Draft": {"seed": 1, "search_s": 1.0},
    "MissionFile": {"waypoints": ()},
    "Nod": {"amplitude_rad": 0.1, "period_s": 1.0},
    "NodTiming": {"duration_s": 1.0},
    "Rotor": {
        "joint": "rotor_0_joint",
        "position_m": (0.0, 0.0, 0.0),
        "direction": 1.0,
        "idle": 0.0,
        "top": 1.0,
        "time_constant_up_s": 1.0,
        "time_constant_down_s": 1.0,
        "thrust_quadratic": 1.0,
        "thrust_linear": 1.0,
        "moment_m": 1.0,
    },
    "ShutterAnswer": {
        "stamp_s": 0.0,
        "position_m": (0.0, 0.0, 0.0),
        "orientation_xyzw": (0.0, 0.0, 0.0, 1.0),
        **dict.fromkeys(("exposure", "iso", "lux", "blur", "shift", "turn"), 1.0),
    },
    "SimulationParameters": {"world": "empty.world"},
    "WayHome": {"time_s": 1.0, "length_m": 1.0},
    "Waypoint": {"position_m": (0.0, 0.0, 0.0)},
    "WorldFrame": {"latitude_deg": 0.0, "longitude_deg": 0.0},
}
"""What a class needs to be made, where it has no defaults."""

MISFITS: list[tuple[str, dict[str, Any], str]] = [
    ("BallastTankParameters", {"manhole_breadth_m": 2.0}, "manholes do not fit"),
    ("BatteryParameters", {"initial_charge_ah": 6.0}, "capacity"),
    ("BatteryParameters", {"linear_voltage_v": (10.0, -11.0)}, "open-circuit voltage"),
    ("ButtonParameters", {"button_home": 2}, "button"),
    ("CepaParameters", {"body_radius": 0.5}, "body_radius"),
    ("CepaParameters", {"floor_height": 3.0, "ceiling_height": 3.0}, "floor_height"),
    ("CepaParameters", {"r_lb": 1.2}, "r_lb"),
    ("CepaParameters", {"speed_fractions": ("fast",)}, "speed_fractions"),
    ("CepaParameters", {"speed_fractions": ()}, "speed_fractions"),
    ("CepaParameters", {"speed_fractions": (1.0, 1.5)}, "speed_fractions"),
    ("CepaParameters", {"speed_fractions": [10**400]}, "speed_fractions"),
    ("CepaParameters", {"v_min": 2.0, "v_max": 1.0}, "v_min"),
    ("CloudOdometryParameters", {"first_reach_m": 0.01}, "last_reach_m"),
    ("EnergyParameters", {"reserve": 0.05}, "reserve"),
    ("ExplorerParameters", {"elevation_min": 0.3, "elevation_max": 0.1}, "elevation_max"),
    ("Hold3DParameters", {"frame_spacing_m": 20.0}, "less than half"),
    ("Hold3DParameters", {"hatch_length_m": 29.0}, "hatch does not fit"),
    ("LidarView", {"elevation_deg": (5.0, 5.0)}, "LOW < HIGH"),
    ("LoopClosureParameters", {"rival_distance_m": 0.01}, "rival_distance_m"),
    ("LoopClosureParameters", {"search_agreed_m": 20.0}, "search_agreed_m"),
    ("LoopClosureParameters", {"stretch_m": 10.0}, "stretch_m"),  # maps of 10 m on both sides meet at 20 m
    ("LoopClosureParameters", {"window_min_m": 9.0}, "window_min_m"),
    ("MedianFilterParameters", {"window": 4}, "window"),
    ("PlateParameters", {"reach": 0.3}, "reach"),
    ("PositionControllerParameters", {"max_acceleration": 0.5}, "lower the one or raise the other"),
    ("SlamParameters", {"xmin": -9000.0, "xmax": 9000.0}, "choose a smaller box"),
    ("SlamParameters", {"xmin": 0.0, "xmax": 1e6, "ymin": 0.0, "ymax": 0.05}, "choose a smaller box"),
    ("SlamParameters", {"xmin": 1.0, "xmax": 0.0, "ymin": 0.0, "ymax": 1.0}, "must span an area"),
    ("SlamParameters", {"ymin": 100.0}, "must span an area"),
    ("SurveyCamera", {"tilt_min": 10.0, "tilt_max": -10.0}, "tilt_min"),
    ("TeleopParameters", {"axis_up": 1}, "axis_up"),
    ("ThresholdParameters", {"low": 0.1, "critical": 0.2}, "no greater than the one before"),
    ("TiltParameters", {"place_m": (99.0, 0.0, 0.0)}, "place"),
    ("TiltParameters", {"tilt_min": 50.0, "tilt_max": 0.0}, "tilts from"),
    ("VfhPlus3dParameters", {"alpha_deg": 7.0}, "divide 180"),
    ("VfhPlus3dParameters", {"low": 2.0}, "low <= high"),
    ("VfhPlus3dParameters", {"mu": (5.0, -2.0, 2.0)}, "no negative mu"),
    ("VfhPlus3dParameters", {"opening": 2}, "opening"),
    ("VfhPlus3dParameters", {"voxel_m": 1.0}, "voxel_m"),
    ("YawRegulatorParameters", {"speed_on": 0.1, "speed_off": 0.1}, "speed_on"),
]
"""(class, values, what the sentence must name)."""


def parameter_classes(folder: str) -> Iterator[type]:
    """Yield each class with a `limited` field of the libraries in `src` or in `ros` of the packages."""
    for path in sorted(ROOT.glob(f"src/**/{folder}/**/*.py")):
        parts = path.relative_to(ROOT / "src").with_suffix("").parts
        if "test" in parts or "limited(" not in path.read_text(encoding="utf-8"):
            continue
        name = ".".join(parts[parts.index(folder) + 1 :])
        for each in vars(importlib.import_module(name)).values():
            is_own = getattr(each, "__module__", "") == name and dataclasses.is_dataclass(each)
            if is_own and any("least" in field.metadata for field in dataclasses.fields(each)):
                yield each


def bad_values(field: dataclasses.Field, good: Any) -> Iterator[object]:
    """Yield what a field does not take: not its kind, not finite, and just beyond each limit.

    `good`: an object of the class, whose fields may be limits of each other.
    """
    yield from ("1", [], [1.0])
    if field.default is not None:
        yield None
    if field.type == "bool":
        yield from (1.0, "false")  # a node's parameter may be a whole number, which counts as one
        return
    limits = field.metadata
    low, high = (
        getattr(good, limit) if isinstance(limit, str) else limit
        for limit in (limits["least"], limits["most"])
    )
    yield from (math.nan, 10**400, True)
    yield from [math.inf] if high != math.inf else []
    yield from [-math.inf] if low not in (None, -math.inf) or high != math.inf else []
    if field.type == "int":
        yield (low if low is not None else limits["above"]) + 0.5
        yield from [int(low) - 1] if low is not None else []
        yield from [int(high) + 1] if high is not None else []
    else:
        yield from [math.nextafter(low, -math.inf)] if low not in (None, -math.inf) else []
        yield from [math.nextafter(high, math.inf)] if high not in (None, math.inf) else []
    yield from (limits[side] for side in ("above", "below") if limits[side] is not None)


def complaint(made: type, called: str, given: dict[str, object]) -> str:
    """Return what is wrong with how a class answers bad values; empty: it refuses them in one sentence."""
    try:
        made(**{**NEEDED.get(made.__name__, {}), **given})
    except Exception as error:
        said = str(error)
        is_told = type(error).__module__ != "builtins" or type(error) is ValueError
        if is_told and called in said and said.endswith(".") and "\n" not in said:
            return ""
        return f"{type(error).__name__}: {said}"
    return "it is taken"


@pytest.mark.parametrize("folder", ["src", pytest.param("ros", marks=pytest.mark.ros)])
def test_what_a_field_does_not_allow_is_refused_in_one_sentence_that_names_it(folder):
    found = list(parameter_classes(folder))
    assert len(found) >= (60 if folder == "src" else 3)
    wrong = []
    for each in found:
        good = each(**NEEDED.get(each.__name__, {}))
        for field in dataclasses.fields(each):
            if "least" in field.metadata or field.type == "bool":
                called = field.metadata.get("named") or field.name
                for value in bad_values(field, good):
                    answer = complaint(each, called, {field.name: value})
                    wrong += [f"{each.__name__}({field.name}={value!r}): {answer}"[:200]] if answer else []
    assert not wrong, "\n".join(wrong)


def test_what_does_not_fit_each_other_is_refused_in_one_sentence():
    classes = {each.__name__: each for each in parameter_classes("src")}
    answers = [(name, given, complaint(classes[name], called, given)) for name, given, called in MISFITS]
    assert not [told for told in answers if told[2]]
