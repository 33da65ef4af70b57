#!/usr/bin/env python3
"""Print a run's headline figures; exit with 0 only if the run did what it should.

usage: summarise.py RESULT_JSON
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

# key in result.json: label, unit
HEADLINES = {
    "reached_goal": ("goal reached", ""),
    "collision": ("collision", ""),
    "min_clearance_m": ("least clearance", "m"),
    "flight_time_s": ("flight time", "s"),
    "path_length_m": ("path length", "m"),
    "cepa_computation_ms": ("CEPA's computation", "ms"),
    "latency_ms": ("scan to setpoint", "ms"),
    "real_time_factor": ("real-time factor", ""),
    "seed": ("seed", ""),
}


def text_of(value: object, unit: str) -> str:
    """Return a figure as a reader wants it; of an object, its parts side by side."""
    if isinstance(value, dict):
        return ", ".join(f"{name} {text_of(part, unit)}" for name, part in value.items())
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        value = f"{value:.4g}"
    return f"{value} {unit}".strip()


def headlines(result: dict) -> list[str]:
    """Return one line for each headline figure that the run has."""
    return [
        f"  {label:<20}{text_of(result[key], unit)}"
        for key, (label, unit) in HEADLINES.items()
        if result.get(key) is not None
    ]


def main(path: Path) -> int:
    """Print the summary of one result.json."""
    try:
        result = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        print(f"{path} cannot be read: {error}", file=sys.stderr)
        return 1
    print("\n".join([f"\nResults in {path.parent}:", *headlines(result)]))
    if result.get("success"):
        return 0
    print(f"The run did not do what it should: {result.get('failure') or 'it says no more than that.'}")
    return 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
