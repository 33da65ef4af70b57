"""How an inspection is flown, and when a photograph is good."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_basics.checks import check_parameters, limited
from inspection.survey.plan import SurveyPlan


@dataclass(frozen=True)
class InspectionParameters:
    """Times, tolerances and what a photograph must be.

    Raises:
        ParameterError: a value out of range.
    """

    time_max: float = limited(3600.0, 1.0, 86_400.0)
    """After so long the UAV comes home, s."""
    speed: float = limited(1.5, 0.05, 20.0)
    """Speed at which the UAV flies, m/s; for the time that a leg may take."""
    passing_speed: float = limited(0.0, 0.0, "speed")
    """Speed at which the UAV takes photographs in passing, m/s; 0: it comes to rest for each. It comes to
    rest, too, for closer looks, and where a photograph failed before.
    """
    arrived: float = limited(0.4, 0.05, 5.0)
    """A corner of the way is passed within this distance, m."""
    ahead: float = limited(1.5, 0.0, 20.0)
    """As in `ExplorationParameters`."""
    climbs_first: bool = False
    """As in `ExplorationParameters`."""
    near: float = limited(0.15, 0.02, 2.0)
    """At a photograph the UAV is at most so far from its place, m."""
    turned: float = limited(1.5, 0.1, 45.0)
    """At a photograph the UAV's front is at most so far from the photograph's, deg."""
    still: float = limited(0.8, 0.01, 1.0)
    """At a photograph the UAV moves and turns so slowly that this share of `blur_max` is blurred."""
    settle: float = limited(0.05, 0.0, 60.0)
    """The UAV is at its place, turned and still for so long before the shutter opens, s."""
    rest: float = limited(1.5, 0.0, 60.0)
    """The shutter opens, too, when the UAV has been at rest for so long within `far`, s. CEPA may keep it off
    a little.
    """
    calm: float = limited(2.5, 0.0, 600.0)
    """After so long near the place the shutter opens at the first instant of rest within `far`, s. Where CEPA
    pushes the UAV about, rest comes and goes.
    """
    patience: float = limited(8.0, 0.5, 600.0)
    """After so long near the place the shutter opens all the same, s, if the UAV is within `far` and moves at
    most twice as fast.
    """
    far: float = limited(0.4, "near", 5.0)
    """The greatest distance from its place at which a photograph is taken after `rest`, `calm` or `patience`,
    m.
    """
    tilt_rate: float = limited(60.0, 1.0, 3600.0)
    """Speed of the gimbal's turn, deg/s. The shutter waits for it."""
    blur_max: float = limited(0.5, 0.05, 1000.0)
    """A photograph with more blur on the surface is shot again, as a share of the detail."""
    lux_min: float = limited(40.0, 0.0, 1e5)
    """A photograph with less light in its middle is shot again, lux."""
    iso_max: float = limited(25600.0, 50.0, 1e6)
    """A photograph with a higher ISO speed is shot again: it is dark."""
    lost_max: float = limited(0.02, 0.0, 1.0)
    """If a greater share of what a photograph is to show is white or black, 0..1, it is taken with another
    exposure, too.
    """
    exposures: int = limited(3, 1, 10)
    """So many exposures of one photograph at most."""
    deviation_max: float = limited(0.5, 0.001, 100.0)
    """A photograph whose place is known less well is shot again, m: the pose's standard deviation."""
    tries: int = limited(3, 1, 20)
    """A photograph that failed so often is left out."""
    wait: float = limited(10.0, 0.0, 600.0)
    """If there is no way to any photograph, the UAV hovers so long before they count as failed, s. The map
    may lack a part for a moment, as after a restart.
    """
    search_hover: float = limited(25.0, 0.0, 86_400.0)
    """While its photographs are searched, the UAV hovers at home so long, s; then it lands. A landing and a
    take-off take about as long.
    """
    nearby: float = limited(0.5, 0.0, 5.0)
    """If there is no way to a photograph's place, it is taken from a place within this distance, m."""
    detail: float = limited(1.0, 0.01, 100.0)
    """Resolution of a photograph, mm per pixel."""
    closer: float = limited(0.3, 0.01, 100.0)
    """Resolution of a closer look, mm per pixel."""
    reach: float = limited(4.5, 1e-4, 1e6)
    """Distance at which the camera's pixel covers as much as the detail, m."""
    exposure: float = limited(2.5e-4, 1e-6, 10.0)
    """Exposure time of a photograph, s."""
    look_period: float = limited(0.5, 0.05, 10.0)
    """Time between two checks of the way, s."""
    home_period: float = limited(2.0, 0.05, 60.0)
    """Time between two plans of the way home, s."""
    home_speed: float = limited(0.8, 0.05, 20.0)
    """Mean speed on the way home, m/s."""
    track_spacing: float = limited(0.5, 0.05, 10.0)
    """Distance between the places that it remembers, to come back the way it came, m."""
    camera_x: float = limited(0.1, -5.0, 5.0)
    """Place of the camera in the UAV's frame, forward, m."""
    camera_y: float = limited(0.0, -5.0, 5.0)
    """Place of the camera in the UAV's frame, to the left, m."""
    camera_z: float = limited(-0.05, -5.0, 5.0)
    """Place of the camera in the UAV's frame, up, m."""

    @property
    def camera_m(self) -> np.ndarray:
        """(3,) of the camera in the UAV's frame."""
        return np.array((self.camera_x, self.camera_y, self.camera_z))

    def for_plan(self, plan: SurveyPlan) -> InspectionParameters:
        """Return them for the photographs of a plan, by its camera and its flight.

        It passes at most as fast as it flies, and as the blur allows.
        """
        detail_mm, camera = plan.asked.resolution, plan.camera
        reach_m = 1e-3 * detail_mm * camera.focal_px
        own = replace(self, detail=detail_mm, reach=reach_m, exposure=camera.exposure)
        sharp_m_s = 1e-3 * own.still * own.most_blur_mm() / camera.exposure
        return replace(own, passing_speed=min(plan.flying.shooting_speed, sharp_m_s, self.speed))

    def detail_m(self, is_closer: bool = False) -> float:
        """Return what a pixel covers at most of what a photograph is to show, m."""
        return 1e-3 * (self.closer if is_closer else self.detail)

    def blur_mm(self, shift_m: float, turn_rad: float, is_closer: bool = False) -> float:
        """Return what a motion during the exposure blurs on the surface, where the detail is just drawn, mm.

        A near surface blurs by more px, but no more on the surface.
        """
        return 1e3 * (shift_m + self._share(is_closer) * self.reach * turn_rad)

    def most_blur_mm(self, is_closer: bool = False) -> float:
        """Return the blur on the surface that is allowed, mm."""
        return self.blur_max * self._share(is_closer) * self.detail

    def _share(self, is_closer: bool) -> float:
        return self.closer / self.detail if is_closer else 1.0

    def __post_init__(self) -> None:
        check_parameters(self)
