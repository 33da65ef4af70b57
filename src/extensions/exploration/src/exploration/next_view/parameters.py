"""What the explorer is made with."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ParameterError


@dataclass(frozen=True)
class ExplorerParameters:
    """The lidar, and what an exploration is worth.

    Raises:
        ParameterError: a value out of range.
    """

    elevation_min: float = limited(-math.radians(15.0), -math.pi / 2, math.pi / 2)
    """Of the lowest beam of the level lidar, rad. It sees all around."""
    elevation_max: float = limited(math.radians(15.0), -math.pi / 2, math.pi / 2)
    """Of the highest beam of the level lidar, rad."""
    reach: float = limited(10.0, 0.5, 200.0)
    """Nothing is expected to be seen from farther than this, m."""
    near: float = limited(0.5, 0.0, "reach")
    """Nothing nearer than this is seen, m."""
    cell: float = limited(0.8, 0.05, 10.0)
    """Unknown places within a cube of this side count together, m."""
    spacing: float = limited(0.8, 0.05, 10.0)
    """Distance between places from which the UAV could look, m."""
    way_spacing: float = limited(0.0, 0.0, "spacing")
    """Distance between places that the UAV's ways lead through, m, at least 2 voxels. Wider than what an
    opening leaves for the UAV's centre, it loses the opening. 0: as `spacing`.
    """
    worth_min: float = limited(0.4, 0.0, 1e3)
    """A view is worth a flight if it shows so many m2 of the border of what is known. Border that may open
    room for the UAV itself is always worth it.
    """
    rate_min: float = limited(0.2, 0.0, 1e3)
    """A view is worth a flight if it shows so many m2 of the border for each second that it costs."""
    room_min: float = limited(0.0, 0.0, 1e3)
    """Unknown room for the UAV itself counts from so many m3 in one piece. At 0 all counts."""
    view_choice: str = "border"
    """How the next best view is chosen. `border`: by the border of what is known. `volume`: by the unknown
    volume that it would show, for places of many small rooms, and high ones. See `VIEW_CHOICES`.
    """
    volume_min: float = limited(0.5, 0.0, 1e3)
    """By volume a view is worth a flight if it shows so many m3."""
    volume_rate: float = limited(0.2, 0.0, 1e3)
    """By volume a view is worth a flight if it shows so many m3 for each second that it costs."""
    shafts: bool = False
    """Holes and shafts that no level view shows come before all other room; the UAV goes straight in. With
    `steep` of the exploration, and not by volume, which weighs such views by itself.
    """
    near_first: float = limited(4.0, 0.0, 1e3)
    """By volume: before the UAV flies farther than this, it takes what is small and nearer, m."""
    speed: float = limited(1.0, 0.01, 20.0)
    """Speed of the UAV, m/s."""
    pause: float = limited(2.0, 0.0, 60.0)
    """Time that each view costs besides the way, s."""
    keep: float = limited(1.5, 1.0, 100.0)
    """The UAV goes on to its present goal unless another one is worth so many times as much a second."""

    def __post_init__(self) -> None:
        check_parameters(self)
        if self.elevation_min > self.elevation_max:
            raise ParameterError(
                f"elevation_min {self.elevation_min:g} is above elevation_max {self.elevation_max:g}."
            )

    @property
    def slopes(self) -> tuple[float, float]:
        """Of the lowest and the highest beam."""
        return math.tan(self.elevation_min), math.tan(self.elevation_max)


@dataclass(frozen=True)
class ExplorationParameters:
    """How an exploration is led.

    Raises:
        ParameterError: a value out of range.
    """

    time_max: float = limited(math.inf, above=0.0, most=math.inf)
    """After this time the UAV flies home, s."""
    look_period: float = limited(1.0, 0.1, 60.0)
    """The way is checked, and the next view is decided anew, so often, s."""
    rest: float = limited(0.3, 0.0, 60.0)
    """Time that the UAV hovers at a view, so that clouds come before the next decision, s."""
    sweep: float = limited(0.0, 0.0, 60.0)
    """A lidar that nods where the UAV hovers needs so long to see all around, s. Then the UAV decides only
    after it has hovered so long. 0: the lidar sees all the time.
    """
    arrived: float = limited(0.3, 0.05, 5.0)
    """The UAV has arrived if it is nearer than this, m."""
    ahead: float = limited(1.5, 0.0, 20.0)
    """The UAV aims at places on its way so far ahead, if a straight line there is clear and hardly dearer
    than the way, m. Below the way in which the position controller brakes, it flies slower.
    """
    climbs_first: bool = False
    """The UAV climbs or sinks on the spot while the level way to where it aims is not clear. For a CEPA that
    sees one height only, and so no manhole below or above.
    """
    patience: float = limited(6.0, 1.0, 600.0)
    """A place that the UAV comes no nearer to for so long is closed for a while, and its view is given up, s.
    CEPA may keep the UAV off.
    """
    stranded: float = limited(60.0, 1.0, 600.0)
    """On its way home, a UAV that stays where it is for so long must land there, s."""
    track_spacing: float = limited(0.5, 0.1, 10.0)
    """Distance between the places that it remembers, to come back the way it came, m."""
    first_sink: float = limited(0.7, 0.0, 5.0)
    """The hover's height is the border of what the climb has shown: home is this much below, m."""
    steep: bool = False
    """When no view shows more, the UAV goes straight up and down by small steps into what is unknown; by
    volume, up to 2 m whenever that is worth it. It needs range finders up and down, and CEPA that flies only
    into what they have seen.
    """
    climb_max: float = limited(math.inf, 0.0, math.inf)
    """The UAV stays lower than its first hover plus this, m. A planar lidar knows its place only near the
    height of its map.
    """
    home_speed: float = limited(0.7, 0.01, 20.0)
    """Mean speed on the way home, turns included, m/s; slower, where this flight has been."""
    home_period: float = limited(5.0, 0.5, 60.0)
    """The way home is planned anew so often, s."""

    def __post_init__(self) -> None:
        check_parameters(self)
