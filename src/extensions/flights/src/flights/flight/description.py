"""The description of a run with a goal or a mission."""

from __future__ import annotations

from dataclasses import dataclass, field

from flights.worlds.scenario import Scenario


@dataclass(frozen=True)
class RunDescription:
    """The description of a run.

    parameters: all nodes' parameters by node; algorithm, lidar: the chosen names.
    """

    experiment: str
    scenario: Scenario
    algorithm: str
    lidar: str
    seed: int
    model: str = "iris"
    parameters: dict[str, dict] = field(default_factory=dict)
    lidar_in_body_xyz_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
