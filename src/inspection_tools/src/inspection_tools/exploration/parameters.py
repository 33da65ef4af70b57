"""What the explorer is made with."""

from __future__ import annotations

import math
from dataclasses import dataclass

from inspection_tools.checks import check_flag, check_number
from inspection_tools.errors import ParameterError


@dataclass(frozen=True)
class ExplorerParameters:
    """The lidar, and what an exploration is worth.

    Attributes:
        elevation_min, elevation_max: Of the lowest and of the highest beam of the level lidar, rad. It sees
            all around.
        reach: Nothing is expected to be seen from farther than this, m.
        near: Nothing nearer than this is seen, m.
        cell: Unknown places within a cube of this side count together, m.
        spacing: Between places from which the UAV could look, m.
        way_spacing: Between places that its ways lead through, m, at least 2 voxels. Wider than what an
            opening leaves for the UAV's centre, it loses the opening. 0: as `spacing`.
        worth_min: A view is worth a flight if it shows so many m2 of the border of what is known. Border that
            may open room for the UAV itself is always worth it.
        rate_min: And so many m2 for each second that it costs.
        room_min: Unknown room for the UAV itself counts from so many m3 in one piece. At 0 all counts.
        view_choice: How the next best view is chosen. `border`: by the border of what is known. `volume`: by
            the unknown volume that it would show, for places of many small rooms, and high ones. See
            `VIEW_CHOICES`.
        volume_min, volume_rate: By volume a view is worth a flight if it shows so many m3, and so many for
            each second.
        shafts: Holes and shafts that no level view shows come before all other room; the UAV goes straight
            in. With `steep` of the exploration, and not by volume, which weighs such views by itself.
        near_first: And before the UAV flies farther than this, it takes what is small and nearer, m.
        speed: Of the UAV, m/s.
        pause: Time that each view costs besides the way, s.
        keep: The UAV goes on to its present goal unless another one is worth so many times as much a second.

    Raises:
        ParameterError: a value out of range.
    """

    elevation_min: float = -math.radians(15.0)
    elevation_max: float = math.radians(15.0)
    reach: float = 10.0
    near: float = 0.5
    cell: float = 0.8
    spacing: float = 0.8
    way_spacing: float = 0.0
    worth_min: float = 0.4
    rate_min: float = 0.2
    room_min: float = 0.0
    view_choice: str = "border"
    volume_min: float = 0.5
    volume_rate: float = 0.2
    shafts: bool = False
    near_first: float = 4.0
    speed: float = 1.0
    pause: float = 2.0
    keep: float = 1.5

    def __post_init__(self) -> None:
        check_number("elevation_min", self.elevation_min, -math.pi / 2, math.pi / 2)
        check_number("elevation_max", self.elevation_max, -math.pi / 2, math.pi / 2)
        if self.elevation_min > self.elevation_max:
            raise ParameterError(
                f"elevation_min {self.elevation_min:g} is above elevation_max {self.elevation_max:g}."
            )
        check_number("reach", self.reach, 0.5, 200.0)
        check_number("near", self.near, 0.0, self.reach)
        check_number("cell", self.cell, 0.05, 10.0)
        check_number("spacing", self.spacing, 0.05, 10.0)
        check_number("way_spacing", self.way_spacing, 0.0, self.spacing)
        check_number("worth_min", self.worth_min, 0.0, 1e3)
        check_number("rate_min", self.rate_min, 0.0, 1e3)
        check_number("room_min", self.room_min, 0.0, 1e3)
        check_number("volume_min", self.volume_min, 0.0, 1e3)
        check_number("volume_rate", self.volume_rate, 0.0, 1e3)
        check_flag("shafts", self.shafts)
        check_number("near_first", self.near_first, 0.0, 1e3)
        check_number("speed", self.speed, 0.01, 20.0)
        check_number("pause", self.pause, 0.0, 60.0)
        check_number("keep", self.keep, 1.0, 100.0)

    @property
    def slopes(self) -> tuple[float, float]:
        """Of the lowest and the highest beam."""
        return math.tan(self.elevation_min), math.tan(self.elevation_max)


@dataclass(frozen=True)
class ExplorationParameters:
    """How an exploration is led.

    Attributes:
        time_max: After this time the UAV flies home, s.
        look_period: The way is checked, and the next view is decided anew, so often, s.
        rest: At a view, so that clouds come before the next decision, s.
        sweep: A lidar that nods where the UAV hovers needs so long to see all around, s. Then the UAV decides
            only after it has hovered so long. 0: the lidar sees all the time.
        arrived: The UAV has arrived if it is nearer than this, m.
        ahead: The UAV aims at places on its way so far ahead, if a straight line there is clear and hardly
            dearer than the way, m. Below the way in which the position controller brakes, it flies slower.
        climbs_first: The UAV climbs or sinks on the spot while the level way to where it aims is not clear.
            For a CEPA that sees one height only, and so no manhole below or above.
        patience: A place that the UAV comes no nearer to for so long is closed for a while, and its view is
            given up, s. CEPA may keep the UAV off.
        stranded: On its way home, a UAV that stays where it is for so long must land there, s.
        track_spacing: Between the places that it remembers, to come back the way it came, m.
        first_sink: The hover's height is the border of what the climb has shown: home is this much below, m.
        steep: When no view shows more, the UAV goes straight up and down by small steps into what is unknown;
            by volume, up to 2 m whenever that is worth it. It needs range finders up and down, and CEPA that
            flies only into what they have seen.
        climb_max: The UAV stays lower than its first hover plus this, m. A planar lidar knows its place only
            near the height of its map.
        home_speed: Mean speed on the way home, turns included, m/s; slower, where this flight has been.
        home_period: The way home is planned anew so often, s.

    Raises:
        ParameterError: a value out of range.
    """

    time_max: float = math.inf
    look_period: float = 1.0
    rest: float = 0.3
    sweep: float = 0.0
    arrived: float = 0.3
    ahead: float = 1.5
    climbs_first: bool = False
    patience: float = 6.0
    stranded: float = 60.0
    track_spacing: float = 0.5
    first_sink: float = 0.7
    steep: bool = False
    climb_max: float = math.inf
    home_speed: float = 0.7
    home_period: float = 5.0

    def __post_init__(self) -> None:
        check_flag("steep", self.steep)
        check_flag("climbs_first", self.climbs_first)
        if not self.time_max > 0.0:
            raise ParameterError(f"time_max is {self.time_max}; it must be a positive number of seconds.")
        check_number("look_period", self.look_period, 0.1, 60.0)
        check_number("rest", self.rest, 0.0, 60.0)
        check_number("sweep", self.sweep, 0.0, 60.0)
        check_number("arrived", self.arrived, 0.05, 5.0)
        check_number("ahead", self.ahead, 0.0, 20.0)
        check_number("patience", self.patience, 1.0, 600.0)
        check_number("stranded", self.stranded, 1.0, 600.0)
        check_number("track_spacing", self.track_spacing, 0.1, 10.0)
        check_number("first_sink", self.first_sink, 0.0, 5.0)
        if not self.climb_max >= 0.0:
            raise ParameterError(f"climb_max is {self.climb_max}; it must be a height in metres, 0 or more.")
        check_number("home_speed", self.home_speed, 0.01, 20.0)
        check_number("home_period", self.home_period, 0.5, 60.0)
