"""What a survey asks for, and the UAV that flies it."""

from __future__ import annotations

from dataclasses import dataclass

from flight_basics.checks import check_number, check_parameters, limited

HOVER_W, GRAVITY_M_S2 = 3.12, 9.81
OUTSIDE_M = 6.0
"""Around a mesh that is surveyed from outside; a photograph of 1 mm per pixel is taken from 4.5 m."""


@dataclass(frozen=True)
class SurveyParameters:
    """What the photographs must show, and how the planner searches.

    Raises:
        ParameterError: a value out of range.
    """

    resolution: float = limited(1.0, 0.01, 100.0)
    """Resolution of the surface in a photograph, in the worst direction, mm per pixel."""
    incidence: float = limited(60.0, 1.0, 85.0)
    """Greatest angle between the surface's normal and the line of sight, deg."""
    share: float = limited(0.98, 0.01, 1.0)
    """Of the surface that can be photographed, this much is to be: 0..1."""
    class_share: float = limited(0.95, 0.0, 1.0)
    """Of each class of parts, this much of what can be photographed is to be: 0..1."""
    patch: float = limited(0.25, 0.05, 5.0)
    """Side of the patches into which the surface is divided, m."""
    voxel: float = limited(0.1, 0.02, 1.0)
    """Side of the voxels in which the UAV's room is known, m. Of a map, its own."""
    spacing: float = 0.0
    """Spacing of the lattice of places from which photographs are tried, m; 0: the UAV's width."""
    radius: float = limited(0.35, 0.05, 5.0)
    """Radius of the UAV, rotors included, m."""
    margin: float = 0.15
    """Kept beyond the radius, m. Below 0 only where the surfaces are known to be too near, as in a map."""
    comfort: float = limited(0.0, 0.0, 5.0)
    """Kept beyond the radius where it can be, m. Nearer places are tried only if they show what no other
    does.
    """
    pointing_error: float = limited(0.5, 0.0, 10.0)
    """Pointing error of the camera, deg; the picture's edge counts as this much narrower."""
    finer: float = limited(0.0, 0.0, 0.5)
    """Photographs are planned for a resolution that is finer by this share, as the UAV is never quite at its
    place.
    """
    around: float = limited(0.0, 0.0, 100.0)
    """The UAV may fly so far outside the box around a mesh, m."""
    outside: bool = False
    """The mesh is surveyed from outside: the UAV flies into nothing that surfaces enclose, and not below the
    mesh. `around` is 6 m then, unless it is given.
    """
    planning: str = "greedy"
    """How the photographs are planned: `greedy`. See `PHOTOGRAPH_PLANNINGS`."""

    def __post_init__(self) -> None:
        check_parameters(self)
        if self.spacing:
            check_number("spacing", self.spacing, 0.1, 10.0)
        check_number("margin", self.margin, -0.5 * self.radius, 5.0)

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

    The last three, and endurance, are those of `exploration.energy`: the flight does not break off.

    Raises:
        ParameterError: a value out of range.
    """

    speed: float = limited(1.5, 0.05, 20.0)
    """Greatest speed between photographs, m/s."""
    acceleration: float = limited(1.0, 0.05, 20.0)
    """Greatest acceleration, m/s^2."""
    passing: bool = False
    """Whether it shoots in passing; else it hovers for each photograph."""
    passing_speed: float = limited(0.5, 0.01, "speed")
    """Speed while it shoots in passing, m/s. Times the exposure it is the blur."""
    settle: float = limited(0.1, 0.0, 60.0)
    """Time from the stop to the photograph in the hover, s."""
    yaw_rate: float = limited(90.0, 1.0, 720.0)
    """Rate of the UAV's turns, deg/s."""
    tilt_rate: float = limited(60.0, 1.0, 720.0)
    """Rate of the gimbal's turns, deg/s."""
    mass: float = limited(2.27, 0.05, 100.0)
    """Mass of the UAV with lidar, camera and lamp, kg. An Iris with Puck, camera and lamp by default."""
    battery: float = limited(56.6, 0.1, 10_000.0)
    """Energy of the full battery, Wh."""
    electronics: float = limited(40.5, 0.0, 10_000.0)
    """Power of all but the rotors, W: computer, lidar, camera, lamp."""
    endurance: float | None = limited(None, 30.0, 86_400.0)
    """Time in which a full battery gets empty, s; None: that of a hover (`endurance_s`)."""
    reserve: float = limited(0.12, 0.0, 0.9)
    """Charge that is left after the landing: 0..1."""
    way_home_margin: float = limited(1.3, 1.0, 5.0)
    """What the way home may take, as a multiple of what is reckoned."""
    landing_time: float = limited(10.0, 0.0, 600.0)
    """Time of a landing, s; it counts for the take-off, too."""

    def __post_init__(self) -> None:
        check_parameters(self)

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
