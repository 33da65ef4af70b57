"""What an exploration tells: feedback, result, and markers for RViz."""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import Point
from sensor_msgs.msg import BatteryState
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from exploration.msg import ExploreFeedback, ExploreResult
from exploration.next_view import Exploration

PLAN, HOME, LEFT = ColorRGBA(0.1, 0.4, 1.0, 1.0), ColorRGBA(0.1, 0.7, 0.2, 1.0), ColorRGBA(0.9, 0.1, 0.1, 0.6)
WH = 3600.0
ABOVE_M = np.array((0.0, 0.0, 0.8))
"""The words, over the UAV."""
SHOWN_M2 = 0.3
"""A smaller place that stays unknown has no words in RViz."""


def phase_of(exploration: Exploration, has_map: bool) -> str:
    """Return what an exploration does, in words."""
    if not has_map:
        return "waiting for the map"
    if exploration.explored.end is not None:
        return "coming home"
    if exploration.is_paused:
        return "paused"
    return "waiting for SLAM" if exploration.is_in_doubt else "exploring"


def feedback_of(
    exploration: Exploration, battery: BatteryState | None, rate_per_s: float, has_map: bool
) -> ExploreFeedback:
    """Return the feedback. rate_per_s: share of the charge that a second takes."""
    explored, way = exploration.explored, exploration.way_home
    feedback = ExploreFeedback(phase=phase_of(exploration, has_map))
    feedback.known = explored.known_m3[-1][1] if explored.known_m3 else 0.0
    watts = math.nan if battery is None else abs(battery.voltage * battery.current)
    feedback.charge = math.nan if battery is None else battery.percentage
    feedback.energy_left = watts * feedback.charge / rate_per_s / WH
    feedback.home_way = math.nan if way is None else way.length_m
    feedback.home_time = math.nan if way is None else way.time_s
    feedback.home_energy = watts * feedback.home_time / WH
    rest_m = exploration.rest_m
    if rest_m:
        feedback.setpoint, feedback.view = Point(*rest_m[0]), Point(*rest_m[-1])
    return feedback


def result_of(exploration: Exploration) -> ExploreResult:
    """Return the result."""
    explored = exploration.explored
    return ExploreResult(
        end="" if explored.end is None else explored.end.value,
        reason=" ".join(filter(None, (explored.reason, explored.height_words))),
        is_home=exploration.is_home,
        known=explored.known_m3[-1][1] if explored.known_m3 else 0.0,
        views=explored.views,
        unknown_places=[Point(*leftover.place_m) for leftover in explored.leftovers],
        unknown_areas=[leftover.area_m2 for leftover in explored.leftovers],
        unknown_reasons=[leftover.words for leftover in explored.leftovers],
    )


def markers_of(
    exploration: Exploration, feedback: ExploreFeedback, here_m: np.ndarray, header: Header
) -> MarkerArray:
    """Return plan and chosen view (blue), way home with its energy (green), and what stays unknown (red)."""
    rest_m = exploration.rest_m
    shown = [_line(header, "plan", PLAN, [here_m, *rest_m])]
    shown.append(_marker(header, "view", Marker.SPHERE, PLAN, 0.4, rest_m[-1] if rest_m else here_m))
    home_m = exploration.home_way_m
    if home_m is not None:
        shown.append(_line(header, "home", HOME, list(home_m)))
        words = f"home {feedback.home_way:.0f} m, {feedback.home_time:.0f} s"
        if math.isfinite(feedback.home_energy):
            words += f", {feedback.home_energy:.1f} of {feedback.energy_left:.1f} Wh"
        shown.append(_words(header, "home_words", here_m + ABOVE_M, f"{feedback.phase}\n{words}", 0))
    left = exploration.explored.leftovers
    cubes = _marker(header, "unknown", Marker.CUBE_LIST, LEFT, 0.3, np.zeros(3))
    cubes.points = [Point(*leftover.place_m) for leftover in left]
    if left:
        shown.append(cubes)
    large = [leftover for leftover in left if leftover.area_m2 >= SHOWN_M2][:30]
    shown += [
        _words(header, "why", np.array(leftover.place_m), leftover.why.value, number)
        for number, leftover in enumerate(large)
    ]
    return MarkerArray([_marker(header, "", Marker.DELETEALL, PLAN, 1.0, np.zeros(3)), *shown])


def _marker(
    header: Header, name: str, kind: int, colour: ColorRGBA, size_m: float, place_m: np.ndarray
) -> Marker:
    marker = Marker(header=header, ns=name, type=kind, color=colour)
    marker.action = Marker.DELETEALL if kind == Marker.DELETEALL else Marker.ADD
    if marker.action == Marker.DELETEALL:
        marker.type = Marker.ARROW
    marker.pose.position, marker.pose.orientation.w = Point(*place_m), 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = size_m
    return marker


def _line(header: Header, name: str, colour: ColorRGBA, places_m: list[np.ndarray]) -> Marker:
    line = _marker(header, name, Marker.LINE_STRIP, colour, 0.08, np.zeros(3))
    line.points = [Point(*place_m) for place_m in places_m]
    if len(places_m) < 2:  # RViz calls such a line an error, and shows the display's name in red
        line.action = Marker.DELETE
    return line


def _words(header: Header, name: str, place_m: np.ndarray, words: str, number: int) -> Marker:
    marker = _marker(header, name, Marker.TEXT_VIEW_FACING, ColorRGBA(0.0, 0.0, 0.0, 1.0), 0.35, place_m)
    marker.text, marker.id = words, number
    return marker
