"""RViz markers of what CEPA sees and decides."""

from __future__ import annotations

import math

import numpy as np
import rospy
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from cepa import CepaParameters, view
from cepa.decision import Vector2
from cepa.scan import Beams
from cepa_ros import decision_message
from cepa_ros.decision_message import BRAKING, MOVER, PREDICTED

Rgb = tuple[float, float, float]
Rgba = tuple[float, float, float, float]

WHITE, GREY, RED = (1.0, 1.0, 1.0), (0.5, 0.5, 0.5), (0.9, 0.1, 0.1)
INNER, OUTER = (1.0, 0.45, 0.1), (0.3, 0.75, 1.0)
PARTLY, WHOLLY = (1.0, 0.75, 0.1), (0.85, 0.1, 0.1)
RING_WIDTH_M = 0.08
PATH_STEP = 2
PATH_WIDTH_M, BRAKING_WIDTH_M = 0.05, 0.14
MOVER_S = 1.0
"""A mover's line ends where it will be after so long."""
ARROW_HEIGHT_M = 0.04  # over the flat markers and over each other, so that RViz does not mix them


class Canvas:
    """Collects the markers of one instant, one per namespace. A marker without points is deleted."""

    def __init__(self, header: Header) -> None:
        self._header = header
        self.markers = MarkerArray()

    def lines(
        self,
        name: str,
        points: np.ndarray,
        colour: Rgb,
        width_m: float,
        alpha: float = 1.0,
        height_m: float = 0.0,
    ) -> None:
        """Draw a closed or open line through ``points`` (n, 2) or (n, 3)."""
        self._add(name, Marker.LINE_STRIP, points, [(*colour, alpha)], width_m, height_m)

    def segments(self, name: str, ends: np.ndarray, colours: list[Rgba], width_m: float) -> None:
        """Draw lines between ``ends`` (n, 2, 2); ``colours`` holds one (r, g, b, a), or one per line."""
        colours = [colour for colour in colours for _ in range(2)] if len(colours) > 1 else colours
        self._add(name, Marker.LINE_LIST, ends.reshape(-1, 2), colours, width_m)

    def area(self, name: str, outline: np.ndarray, colour: Rgb, alpha: float) -> None:
        """Fill the star-shaped outline (n, 2) about the origin."""
        corners = np.stack([np.zeros_like(outline[1:]), outline[:-1], outline[1:]], axis=1)
        self._add(name, Marker.TRIANGLE_LIST, corners.reshape(-1, 2), [(*colour, alpha)], 1.0)

    def arrow(self, name: str, velocity: Vector2 | None) -> None:
        """Draw one of the decision's velocities; None takes its arrow away."""
        height_m = ARROW_HEIGHT_M * (1 + list(decision_message.COLOURS).index(name))
        marker = decision_message.arrow(self._header, name, velocity or (0.0, 0.0), height_m)
        self._append(marker, visible=velocity is not None)

    def _add(
        self,
        name: str,
        kind: int,
        points: np.ndarray,
        colours: list[Rgba],
        width_m: float,
        height_m: float = 0.0,
    ) -> None:
        marker = Marker(ns=name, id=0, type=kind)
        marker.header.stamp, marker.header.frame_id = self._header.stamp, self._header.frame_id
        marker.pose.position.z, marker.pose.orientation.w = height_m, 1.0
        heights = points[:, 2] if points.shape[1] == 3 else np.zeros(len(points))
        marker.points = [Point(x, y, z) for (x, y), z in zip(points[:, :2].tolist(), heights.tolist())]
        marker.scale.x = marker.scale.y = marker.scale.z = width_m
        marker.color = ColorRGBA(*colours[0]) if colours else ColorRGBA()
        marker.colors = [ColorRGBA(*colour) for colour in colours] if len(colours) > 1 else []
        marker.lifetime = rospy.Duration(decision_message.LIFETIME_S)
        marker.frame_locked = True
        self._append(marker, visible=len(points) > 1)

    def _append(self, marker: Marker, visible: bool) -> None:
        marker.action = Marker.ADD if visible else Marker.DELETE
        self.markers.markers.append(marker)


def draw(
    header: Header,
    beams: Beams,
    message: MarkerArray,
    algorithm: str,
    parameters: CepaParameters,
) -> MarkerArray:
    """Return the markers of one scan and the decision that answers it.

    Args:
        header: of the scan; the markers are in its frame.
        beams: the scan.
        message: of ~decision.
        algorithm: original, improved or dynamic.
        parameters: of the algorithm.
    """
    canvas = Canvas(header)
    velocities = decision_message.read(message)
    v_uav = velocities.get(decision_message.OWN, (0.0, 0.0))
    canvas.lines("r_lb", view.emergency_outline(parameters, v_uav), WHITE, 0.02)
    canvas.lines("r_ub", view.circle(parameters.r_ub), WHITE, 0.01, alpha=0.5)
    emergency = decision_message.ORIGINAL in velocities
    v_out = velocities.get(decision_message.OUTPUT, (0.0, 0.0))
    if algorithm == "dynamic":
        _draw_foreseen(canvas, message, parameters)
    else:
        _draw_cushions(canvas, v_out if not emergency else (0.0, 0.0), algorithm, parameters)
        reference_speed = math.hypot(*velocities.get(decision_message.REFERENCE, (0.0, 0.0)))
        _draw_rejected(canvas, beams, parameters, reference_speed, emergency)
        canvas.segments("intrusions", view.intrusions(beams, parameters, v_uav), [(*RED, 0.9)], 0.01)
    for name in decision_message.COLOURS:
        hidden = emergency and name == decision_message.OUTPUT  # the two proposals show it
        canvas.arrow(name, None if hidden else _moving(velocities.get(name)))
    return canvas.markers


def _draw_foreseen(canvas: Canvas, message: MarkerArray, parameters: CepaParameters) -> None:
    """Draw the predicted path with both cushions along it, the braking path, and what moves.

    The cushions are drawn in the scan's plane, as seen from above.
    """
    predicted = decision_message.read_path(message, PREDICTED)
    middles = predicted[::-PATH_STEP, :2]  # with the last
    for name, radius, colour in (
        ("cushion_ub", parameters.r_ub, OUTER),
        ("cushion_lb", parameters.r_lb, INNER),
    ):
        canvas.segments(name, view.path_edge(middles, radius), [(*colour, 1.0)], 0.025)
        strips = view.path_strips(middles, radius)
        canvas.segments(f"{name}_area", strips, [(*colour, 0.12)], view.STRIP_M)
    braking, colours = decision_message.read_path(message, BRAKING), decision_message.PATH_COLOURS
    canvas.lines(BRAKING, braking, colours[BRAKING], BRAKING_WIDTH_M)
    hull = view.circle(parameters.body_radius) if len(braking) else np.empty((0, 2))
    standstill = np.pad(hull, ((0, 0), (0, 1))) + braking[-1:]
    canvas.lines("standstill", standstill, colours[BRAKING], 0.03)
    canvas.lines(PREDICTED, predicted, colours[PREDICTED], PATH_WIDTH_M, height_m=0.5 * ARROW_HEIGHT_M)
    movers = decision_message.read_movers(message)
    moving = [(*colours[MOVER], 0.9)]
    circles = [view.path_edge(mover[None, :2], mover[4]) for mover in movers]
    canvas.segments(MOVER, np.concatenate([np.empty((0, 2, 2)), *circles]), moving, 0.04)
    tips = movers[:, :2] + MOVER_S * movers[:, 2:4]
    canvas.segments(f"{MOVER} velocity", np.stack([movers[:, :2], tips], axis=1), moving, 0.06)


def _draw_cushions(canvas: Canvas, v_out: Vector2, algorithm: str, parameters: CepaParameters) -> None:
    for name, radius, colour in (
        ("cushion_ub", parameters.r_ub, OUTER),
        ("cushion_lb", parameters.r_lb, INNER),
    ):
        moving = math.hypot(*v_out) > 0.0
        outline = view.cushion_outline(algorithm, v_out, radius, parameters.time_horizon)
        outline = outline if moving else np.empty((0, 2))
        canvas.lines(name, outline, colour, 0.025)
        canvas.area(f"{name}_area", outline, colour, 0.12)


def _draw_rejected(
    canvas: Canvas, beams: Beams, parameters: CepaParameters, speed: float, emergency: bool
) -> None:
    """Draw a ring outside r_ub: red where every speed is rejected, amber where some are, grey: unseen."""
    rejected = view.rejected_directions(beams, parameters, speed)
    shown = ~(rejected == 0.0) & (speed > 0.0) & (not emergency)
    along = np.stack([np.cos(beams.angles), np.sin(beams.angles)], axis=1)[shown]
    ends = np.stack(
        [along * (parameters.r_ub + 0.02), along * (parameters.r_ub + 0.02 + RING_WIDTH_M)], axis=1
    )
    colours = [_tick_colour(share) for share in rejected[shown].tolist()]
    width = max(0.008, 0.8 * beams.increment * parameters.r_ub)
    canvas.segments("rejected", ends, colours, width)


def _tick_colour(share: float) -> Rgba:
    if math.isnan(share):
        return (*GREY, 0.35)
    return (*(WHOLLY if share >= 1.0 else PARTLY), 0.8)


def _moving(velocity: Vector2 | None) -> Vector2 | None:
    return velocity if velocity is not None and math.hypot(*velocity) > 1e-3 else None
