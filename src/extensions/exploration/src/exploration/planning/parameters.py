"""What the path planner is made with."""

from __future__ import annotations

from dataclasses import dataclass

from flight_basics.checks import check_parameters, limited


@dataclass(frozen=True)
class PlannerParameters:
    """Sizes and preferences of the path planner.

    Raises:
        ParameterError: a value out of range.
    """

    radius: float = limited(0.35, 0.05, 5.0)
    """Radius of the UAV, rotors included, m."""
    margin: float = limited(0.2, 0.0, 5.0)
    """Kept beyond the radius, for errors of the map and of the flight, m. The centre of the UAV keeps radius
    + margin from the centre of each voxel that is not known to be free.
    """
    comfort: float = limited(0.5, 0.0, 5.0)
    """A path likes to keep this much more, m."""
    preference: float = limited(0.5, 0.0, 10.0)
    """How much longer a path without comfort seems, as a share of its length. At 0 the shortest path wins."""
    closed_radius: float = limited(1.0, 0.05, 50.0)
    """A place that CEPA does not fly is closed within this radius, m."""
    closed_time: float = limited(30.0, 0.0, 86_400.0)
    """A place that CEPA does not fly is closed for so long, s."""
    landmark_reach: float = limited(0.0, 0.0, 1e3)
    """A path stays within so far of a wall at its own height, m: of something occupied that is 1 m long. A
    planar lidar of short range knows its place only there. 0: it goes anywhere.
    """

    def __post_init__(self) -> None:
        check_parameters(self)

    @property
    def clearance_m(self) -> float:
        """Least distance that a path keeps."""
        return self.radius + self.margin
