"""Each value that a parameter's field does not allow is refused in one sentence, which names the field.

The limits are those of the fields (`limited`), so this holds for every class of every package. What values
must be to each other, and what no field can say, is in the tests of the packages.
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


def complaint(made: type, name: str, called: str, value: object) -> str:
    """Return what is wrong with how a class answers a bad value; empty: it refuses it in one sentence."""
    try:
        made(**{**NEEDED.get(made.__name__, {}), name: value})
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
                    answer = complaint(each, field.name, called, value)
                    wrong += [f"{each.__name__}({field.name}={value!r}): {answer}"[:200]] if answer else []
    assert not wrong, "\n".join(wrong)
