"""How an inspection is flown, and when a photograph is good."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from inspection_tools.checks import check_flag, check_number, check_whole
from inspection_tools.survey.plan import SurveyPlan


@dataclass(frozen=True)
class InspectionParameters:
    """Times, tolerances and what a photograph must be.

    Attributes:
        time_max: After so long the UAV comes home, s.
        speed: At which the UAV flies, m/s; for the time that a leg may take.
        passing_speed: At which it takes photographs in passing, m/s; 0: it comes to rest for each. It comes
            to rest, too, for closer looks, and where a photograph failed before.
        arrived: A corner of the way is passed within this distance, m.
        ahead, climbs_first: As in `ExplorationParameters`.
        near: At a photograph the UAV is at most so far from its place, m.
        turned: Its front is at most so far from the photograph's, deg.
        still: It moves and turns so slowly that this share of `blur_max` is blurred.
        settle: All this holds for so long before the shutter opens, s.
        rest: Or it has been at rest for so long within `far`, s. CEPA may keep it off a little.
        calm: After so long near the place it opens at the first instant of rest within `far`, s. Where CEPA
            pushes the UAV about, rest comes and goes.
        patience: After so long near the place the shutter opens all the same, s, if the UAV is within `far`
            and moves at most twice as fast.
        far: See `patience`, m.
        tilt_rate: Of the gimbal, deg/s. The shutter waits for its turn.
        blur_max: A photograph with more blur on the surface is shot again, as a share of the detail.
        lux_min: And one with less light in its middle.
        iso_max: And one with a higher ISO speed: it is dark.
        lost_max: If a greater share of what it is to show is white or black, 0..1, it is taken with another
            exposure, too.
        exposures: So many exposures of one photograph at most.
        deviation_max: And one whose place is known less well, m: the pose's standard deviation.
        tries: A photograph that failed so often is left out.
        wait: If there is no way to any photograph, the UAV hovers so long before they count as failed, s. The
            map may lack a part for a moment, as after a restart.
        search_hover: While its photographs are searched, the UAV hovers at home so long, s; then it lands. A
            landing and a take-off take about as long.
        nearby: If there is no way to its place, it is taken from a place within this distance, m.
        detail, closer: Resolution of a photograph and of a closer look, mm per pixel.
        reach: Where the camera's pixel covers as much as the detail, m.
        exposure: Of a photograph, s.
        look_period: Between two checks of the way, s.
        home_period: Between two plans of the way home, s.
        home_speed: Of the way home, m/s.
        track_spacing: Between the places of the way it came, m.
        camera_x, camera_y, camera_z: Of the camera in the UAV's frame, m.

    Raises:
        ParameterError: a value out of range.
    """

    time_max: float = 3600.0
    speed: float = 1.5
    passing_speed: float = 0.0
    arrived: float = 0.4
    ahead: float = 1.5
    climbs_first: bool = False
    near: float = 0.15
    turned: float = 1.5
    still: float = 0.8
    settle: float = 0.05
    rest: float = 1.5
    calm: float = 2.5
    patience: float = 8.0
    far: float = 0.4
    tilt_rate: float = 60.0
    blur_max: float = 0.5
    lux_min: float = 40.0
    iso_max: float = 25600.0
    lost_max: float = 0.02
    exposures: int = 3
    deviation_max: float = 0.5
    tries: int = 3
    wait: float = 10.0
    search_hover: float = 25.0
    nearby: float = 0.5
    detail: float = 1.0
    closer: float = 0.3
    reach: float = 4.5
    exposure: float = 2.5e-4
    look_period: float = 0.5
    home_period: float = 2.0
    home_speed: float = 0.8
    track_spacing: float = 0.5
    camera_x: float = 0.1
    camera_y: float = 0.0
    camera_z: float = -0.05

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
        check_number("time_max", self.time_max, 1.0, 86_400.0)
        check_number("speed", self.speed, 0.05, 20.0)
        check_number("passing_speed", self.passing_speed, 0.0, self.speed)
        check_number("arrived", self.arrived, 0.05, 5.0)
        check_number("ahead", self.ahead, 0.0, 20.0)
        check_flag("climbs_first", self.climbs_first)
        check_number("near", self.near, 0.02, 2.0)
        check_number("turned", self.turned, 0.1, 45.0)
        check_number("still", self.still, 0.01, 1.0)
        check_number("settle", self.settle, 0.0, 60.0)
        check_number("rest", self.rest, 0.0, 60.0)
        check_number("calm", self.calm, 0.0, 600.0)
        check_number("patience", self.patience, 0.5, 600.0)
        check_number("far", self.far, self.near, 5.0)
        check_number("tilt_rate", self.tilt_rate, 1.0, 3600.0)
        check_number("blur_max", self.blur_max, 0.05, 1000.0)
        check_number("lux_min", self.lux_min, 0.0, 1e5)
        check_number("iso_max", self.iso_max, 50.0, 1e6)
        check_number("lost_max", self.lost_max, 0.0, 1.0)
        check_whole("exposures", self.exposures, 1, 10)
        check_number("deviation_max", self.deviation_max, 0.001, 100.0)
        check_whole("tries", self.tries, 1, 20)
        check_number("wait", self.wait, 0.0, 600.0)
        check_number("search_hover", self.search_hover, 0.0, 86_400.0)
        check_number("nearby", self.nearby, 0.0, 5.0)
        check_number("detail", self.detail, 0.01, 100.0)
        check_number("closer", self.closer, 0.01, 100.0)
        check_number("reach", self.reach, 1e-4, 1e6)
        check_number("exposure", self.exposure, 1e-6, 10.0)
        check_number("look_period", self.look_period, 0.05, 10.0)
        check_number("home_period", self.home_period, 0.05, 60.0)
        check_number("home_speed", self.home_speed, 0.05, 20.0)
        check_number("track_spacing", self.track_spacing, 0.05, 10.0)
        for axis in ("camera_x", "camera_y", "camera_z"):
            check_number(axis, getattr(self, axis), -5.0, 5.0)
