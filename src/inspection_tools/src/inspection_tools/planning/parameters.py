"""What the path planner is made with."""

from __future__ import annotations

from dataclasses import dataclass

from inspection_tools.checks import check_number


@dataclass(frozen=True)
class PlannerParameters:
    """Sizes and preferences of the path planner.

    Attributes:
        radius: Of the UAV, rotors included, m.
        margin: Beyond the radius, for errors of the map and of the flight, m. The centre of the UAV keeps
            radius + margin from the centre of each voxel that is not known to be free.
        comfort: A path likes to keep this much more, m.
        preference: How much longer a path without comfort seems, as a share of its length. At 0 the shortest
            path wins.
        closed_radius: A place that CEPA does not fly is closed within this radius, m.
        closed_time: So long, s.
        landmark_reach: A path stays within so far of a wall at its own height, m: of something occupied that
            is 1 m long. A planar lidar of short range knows its place only there. 0: it goes anywhere.

    Raises:
        ParameterError: a value out of range.
    """

    radius: float = 0.35
    margin: float = 0.2
    comfort: float = 0.5
    preference: float = 0.5
    closed_radius: float = 1.0
    closed_time: float = 30.0
    landmark_reach: float = 0.0

    def __post_init__(self) -> None:
        check_number("radius", self.radius, 0.05, 5.0)
        check_number("margin", self.margin, 0.0, 5.0)
        check_number("comfort", self.comfort, 0.0, 5.0)
        check_number("preference", self.preference, 0.0, 10.0)
        check_number("closed_radius", self.closed_radius, 0.05, 50.0)
        check_number("closed_time", self.closed_time, 0.0, 86_400.0)
        check_number("landmark_reach", self.landmark_reach, 0.0, 1e3)

    @property
    def clearance_m(self) -> float:
        """Least distance that a path keeps."""
        return self.radius + self.margin
