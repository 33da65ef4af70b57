"""Common arguments of all experiments: algorithm, lidar, seed, model, and limits of the phases."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, Mapping, TypeVar

from flights.errors import ScenarioError
from flights.worlds import scenario

Limits = TypeVar("Limits", bound=Any)


def choices_of(asked: Mapping[str, Any]) -> dict[str, Any]:
    """Return algorithm, lidar, seed and model by these names; raises ScenarioError, SimulationToolsError.

    `mavros` is checked, too.
    """
    scenario.choose("mavros", str(asked.get("mavros", "sim")), scenario.MAVROS)
    model = str(asked.get("model", "iris"))
    return {
        "algorithm": scenario.choose(
            "algorithm", str(asked.get("algorithm", "improved")), scenario.ALGORITHMS
        ),
        "lidar": lidar_of(asked, model),
        "seed": scenario.whole_number("seed", asked.get("seed", 1), *scenario.SEEDS),
        "model": model,
    }


def lidar_of(asked: Mapping[str, Any], model: str) -> str:
    """Return the lidar on a model, checked; raises ScenarioError, SimulationToolsError."""
    lidar = scenario.lidar(str(asked.get("lidar", "ust")))
    if lidar not in scenario.LIDARS:  # these are known to fly
        from flights.launch_arguments.lidar_beams import check_beams  # cepa takes a quarter of a second

        check_beams(model, lidar)
    return lidar


def check_pose_source(asked: Mapping[str, Any], sources: tuple[str, ...]) -> None:
    """Check `pose_source`, which without GNSS cannot be the ground truth; raises ScenarioError."""
    source = scenario.choose("pose_source", str(asked.get("pose_source", "ground_truth")), sources)
    if source == "ground_truth" and str(asked.get("gnss", "true")).lower() == "false":
        others = " or ".join(f"pose_source:={other}" for other in sources if other != source)
        raise ScenarioError(f"Without GNSS the UAV cannot fly by the ground truth; give {others}.")


def limits_of(asked: Mapping[str, Any], kind: type[Limits]) -> Limits:
    """Return the limits (a dataclass) from the values named like its fields; raises FlightError."""
    names = [field.name for field in fields(kind)]
    return kind(**{name: asked[name] for name in names if name in asked})
