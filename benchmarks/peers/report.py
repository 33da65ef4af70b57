"""What a peer's flight leaves in a file: its speed, and how far from its goal it ended."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, fields
from pathlib import Path

from benchmarks.shared.speed import Speed


def write(path: str, speed: Speed, off_m: float) -> None:
    """Write the speed of a flight, and the distance from its goal at the end."""
    Path(path).write_text(json.dumps({**asdict(speed), "off_m": off_m}), encoding="utf-8")


def read(path: Path) -> tuple[Speed, float]:
    """Return what `write` has written.

    Raises:
        ValueError: it is no such file, or a time in it is not positive.
    """
    content = json.loads(path.read_text(encoding="utf-8"))
    try:
        speed = Speed(**{field.name: float(content[field.name]) for field in fields(Speed)})
        off_m = float(content["off_m"])
    except (KeyError, TypeError) as error:
        raise ValueError(f"the report has no usable figures ({error})") from None
    if not all(math.isfinite(value) and value > 0.0 for value in asdict(speed).values()):
        raise ValueError(f"the report has a time that is not positive: {content}")
    return speed, off_m
