"""What a survey asks for, and the UAV that flies it."""

from __future__ import annotations

from dataclasses import dataclass

from inspection_tools.checks import check_flag, check_number

HOVER_W, GRAVITY_M_S2 = 3.12, 9.81
OUTSIDE_M = 6.0
"""Around a mesh that is surveyed from outside; a photograph of 1 mm per pixel is taken from 4.5 m."""


@dataclass(frozen=True)
class SurveyParameters:
    """What the photographs must show, and how the planner searches.

    Attributes:
        resolution: Of the surface in a photograph, in the worst direction, mm per pixel.
        incidence: Greatest angle between the surface's normal and the line of sight, deg.
        share: Of the surface that can be photographed, this much is to be: 0..1.
        class_share: The same for each class of parts alone.
        patch: Side of the patches into which the surface is divided, m.
        voxel: Side of the voxels in which the UAV's room is known, m. Of a map, its own.
        spacing: Of the lattice of places from which photographs are tried, m; 0: the UAV's width.
        radius: Of the UAV, rotors included, m.
        margin: Beyond the radius, m. Below 0 only where the surfaces are known to be too near, as in a map.
        comfort: Beyond the radius, m. Nearer places are tried only if they show what no other does.
        pointing_error: Of the camera, deg; the picture's edge counts as this much narrower.
        finer: Photographs are planned for a resolution that is finer by this share, as the UAV is never quite
            at its place.
        around: The UAV may fly so far outside the box around a mesh, m.
        outside: The mesh is surveyed from outside: the UAV flies into nothing that surfaces enclose, and not
            below the mesh. `around` is 6 m then, unless it is given.
        planning: How the photographs are planned: `greedy`. See `PHOTOGRAPH_PLANNINGS`.

    Raises:
        ParameterError: a value out of range.
    """

    resolution: float = 1.0
    incidence: float = 60.0
    share: float = 0.98
    class_share: float = 0.95
    patch: float = 0.25
    voxel: float = 0.1
    spacing: float = 0.0
    radius: float = 0.35
    margin: float = 0.15
    comfort: float = 0.0
    pointing_error: float = 0.5
    finer: float = 0.0
    around: float = 0.0
    outside: bool = False
    planning: str = "greedy"

    def __post_init__(self) -> None:
        check_number("resolution", self.resolution, 0.01, 100.0)
        check_number("incidence", self.incidence, 1.0, 85.0)
        check_number("share", self.share, 0.01, 1.0)
        check_number("class_share", self.class_share, 0.0, 1.0)
        check_number("patch", self.patch, 0.05, 5.0)
        check_number("voxel", self.voxel, 0.02, 1.0)
        if self.spacing:
            check_number("spacing", self.spacing, 0.1, 10.0)
        check_number("radius", self.radius, 0.05, 5.0)
        check_number("margin", self.margin, -0.5 * self.radius, 5.0)
        check_number("comfort", self.comfort, 0.0, 5.0)
        check_number("pointing_error", self.pointing_error, 0.0, 10.0)
        check_number("finer", self.finer, 0.0, 0.5)
        check_number("around", self.around, 0.0, 100.0)
        check_flag("outside", self.outside)

    @property
    def around_m(self) -> float:
        """How far the UAV may fly outside the box around a mesh."""
        return self.around or (OUTSIDE_M if self.outside else 0.0)

    @property
    def lattice_m(self) -> float:
        """Spacing of the lattice. A small UAV fits between what a coarse lattice would pass over."""
        return self.spacing or 2.0 * self.radius

    @property
    def clearance_m(self) -> float:
        """Least distance of the UAV's centre from every surface."""
        return self.radius + self.margin


@dataclass(frozen=True)
class FlightParameters:
    """How the UAV flies a survey.

    Attributes:
        speed: Greatest, between photographs, m/s.
        acceleration: m/s^2.
        passing: Whether it shoots in passing; else it hovers for each photograph.
        passing_speed: While it shoots in passing, m/s. Times the exposure it is the blur.
        settle: Time from the stop to the photograph in the hover, s.
        yaw_rate, tilt_rate: Of the turns of UAV and gimbal, deg/s.
        mass: Of the UAV with lidar, camera and lamp, kg. An Iris with Puck, camera and lamp by default.
        battery: Energy of the full battery, Wh.
        electronics: Power of all but the rotors, W: computer, lidar, camera, lamp.
        endurance: Time in which a full battery gets empty, s; None: that of a hover (`endurance_s`).
        reserve: Charge that is left after the landing: 0..1.
        way_home_margin: What the way home may take, as a multiple.
        landing_time: s; it counts for the take-off, too.

    The last three, and endurance, are those of `inspection_tools.energy`: the flight does not break off.

    Raises:
        ParameterError: a value out of range.
    """

    speed: float = 1.5
    acceleration: float = 1.0
    passing: bool = False
    passing_speed: float = 0.5
    settle: float = 0.1
    yaw_rate: float = 90.0
    tilt_rate: float = 60.0
    mass: float = 2.27
    battery: float = 56.6
    electronics: float = 40.5
    endurance: float | None = None
    reserve: float = 0.12
    way_home_margin: float = 1.3
    landing_time: float = 10.0

    def __post_init__(self) -> None:
        check_number("speed", self.speed, 0.05, 20.0)
        check_number("acceleration", self.acceleration, 0.05, 20.0)
        check_flag("passing", self.passing)
        check_number("passing_speed", self.passing_speed, 0.01, self.speed)
        check_number("settle", self.settle, 0.0, 60.0)
        check_number("yaw_rate", self.yaw_rate, 1.0, 720.0)
        check_number("tilt_rate", self.tilt_rate, 1.0, 720.0)
        check_number("mass", self.mass, 0.05, 100.0)
        check_number("battery", self.battery, 0.1, 10_000.0)
        check_number("electronics", self.electronics, 0.0, 10_000.0)
        if self.endurance is not None:
            check_number("endurance", self.endurance, 30.0, 86_400.0)
        check_number("reserve", self.reserve, 0.0, 0.9)
        check_number("way_home_margin", self.way_home_margin, 1.0, 5.0)
        check_number("landing_time", self.landing_time, 0.0, 600.0)

    @property
    def endurance_s(self) -> float:
        """Time in which a full battery gets empty: as given, or in the hover of an Iris of this mass.

        Rotors draw 3.12 W times the thrust in newtons to the power of 1.5 (Liu, Sengupta and Kurzhanskiy,
        ICUAS 2017, flown on an IRIS+).
        """
        if self.endurance is not None:
            return self.endurance
        power_w = HOVER_W * (self.mass * GRAVITY_M_S2) ** 1.5 + self.electronics
        return 3600.0 * self.battery / power_w

    @property
    def shooting_speed(self) -> float:
        """Speed of the camera while it shoots, m/s; 0 in the hover."""
        return self.passing_speed if self.passing else 0.0

    @property
    def flight_s(self) -> float:
        """Time of flight that the battery gives before the reserve."""
        return (1.0 - self.reserve) * self.endurance_s
