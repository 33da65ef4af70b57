"""Checks a plan that was edited against the room."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning.kernels.pulling import leg_cost
from flight_basics.errors import SurveyError
from inspection.survey.plan import SurveyPlan
from inspection.survey.surface.room import Room


def check_plan(plan: SurveyPlan, room: Room) -> None:
    """Check that the UAV has room at every photograph and on every way, and the gimbal tilts so far.

    Raises:
        SurveyError: one sentence that names the first photograph that is wrong, and why.
    """
    squares = np.where(room.flyable, room.squares, 0).astype(np.uint16)
    plain, number = np.ones(int(room.squares.max()) + 1), 0
    need_m = room.away_m(room.need)
    for flight in plan.flights:
        here_m = np.array(plan.home_m)
        for each in flight.views:
            number += 1
            tilt = math.degrees(each.view.tilt_rad)
            if not plan.camera.tilt_min - 1e-3 <= tilt <= plan.camera.tilt_max + 1e-3:
                raise SurveyError(
                    f"Photograph {number} has a tilt of {tilt:.1f} deg, but the gimbal has "
                    f"{plan.camera.tilt_min:g} to {plan.camera.tilt_max:g}."
                )
            for place in (*each.way_m, each.view.place_m):
                place_m = np.array(place)
                at = "(" + ", ".join(f"{v:.2f}" for v in place) + ")"
                if not room.at(room.flyable, place_m[None])[0]:
                    away_m = room.away_m(int(room.at(room.squares, place_m[None])[0]))
                    raise SurveyError(
                        f"Photograph {number} is at {at}, {away_m:.2f} m from a surface, or beyond what it "
                        f"reaches; the UAV needs {need_m:.2f} m."
                    )
                if not math.isfinite(
                    leg_cost(squares, room.need, plain, room.inner(here_m), room.inner(place_m))
                ):
                    raise SurveyError(
                        f"The way to photograph {number} at {at} comes nearer than {need_m:.2f} m to a "
                        "surface; give it corners with way: [[x, y, z], ...]."
                    )
                here_m = place_m
