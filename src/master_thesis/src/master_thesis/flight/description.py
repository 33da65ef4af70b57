"""What is flown in a run with a goal or a mission."""

from __future__ import annotations

from dataclasses import dataclass, field

from master_thesis.worlds.scenario import Scenario


@dataclass(frozen=True)
class RunDescription:
    """What was run. parameters: every node's parameters by node name; algorithm, lidar: as chosen."""

    experiment: str
    scenario: Scenario
    algorithm: str
    lidar: str
    seed: int
    model: str = "iris"
    parameters: dict[str, dict] = field(default_factory=dict)
    lidar_in_body_xyz_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
