"""The two worlds of Experiments 3 and 4 (thesis, figures 8.8 and 8.13), drawn by code.

Everything solid stands on the floor and is at least a metre taller than the flight. So a lidar sees the same
plan from the ground, from the flight's height, and from a slightly leaning UAV.
"""

from __future__ import annotations

import math
from typing import Callable

import numpy as np

from flights.worlds.writer import Box, Colour, Cylinder, Part, Prop, Surroundings, write_world

ROOM_X_M, ROOM_Y_M = 16.0, 12.0
"""The room between its walls' faces; its middle is the origin. The thesis gives no size."""

HOLD_X_M, HOLD_Y_M = 30.0, 20.0
BEAM_WIDTH_M, BEAM_DEPTH_M, BEAM_SPACING_M = 1.0, 0.5, 3.0
"""The hold between its plating's faces, its middle at the origin, and the beams on all four sides."""

_CONCRETE_FLOOR = Surroundings(Colour(0.86, 0.86, 0.84), camera=(-13.0, 0.0, 13.0, 0.0, 0.8, 0.0))
_STEEL_FLOOR = Surroundings(Colour(0.70, 0.68, 0.66), camera=(-22.0, 0.0, 22.0, 0.0, 0.8, 0.0))
_PLASTER = Colour(0.88, 0.86, 0.80)
_BRICK = Colour(0.66, 0.36, 0.28)
_BROWN = Colour(0.45, 0.30, 0.18)
_CARDBOARD = Colour(0.74, 0.60, 0.42)
_BLUE = Colour(0.25, 0.42, 0.62)
_PAINTED_STEEL = Colour(0.62, 0.30, 0.24)
_FRAME_STEEL = Colour(0.52, 0.25, 0.20)

_THICK_M = 0.2
_ROOM_HEIGHT_M = 4.0
_HOLD_HEIGHT_M = 8.0
_BOARD_M = 0.04


def _room(rng: np.random.Generator) -> str:
    comment = "Experiment 3: a cluttered room, 16 x 12 m (thesis, figure 8.8)."
    props = (*_shell(ROOM_X_M, ROOM_Y_M, _ROOM_HEIGHT_M, _PLASTER), *_partitions(), *_clutter())
    return write_world("room", comment, _CONCRETE_FLOOR, props)


def _hold(rng: np.random.Generator) -> str:
    return hold_with_beams(BEAM_WIDTH_M, BEAM_SPACING_M)


def hold_with_beams(width_m: float, spacing_m: float) -> str:
    """Return the hold with beams this wide (0: none) and this far from middle to middle."""
    beams_are = f"beams {width_m:g} m wide on its sides"
    comment = f"Experiment 4: a cargo hold, 30 x 20 m, with {beams_are} (thesis, figure 8.13)."
    beams = _beams(width_m, spacing_m) if width_m else ()
    props = (*_shell(HOLD_X_M, HOLD_Y_M, _HOLD_HEIGHT_M, _PAINTED_STEEL), *beams)
    return write_world("hold", comment, _STEEL_FLOOR, props)


MAKERS: dict[str, Callable[[np.random.Generator], str]] = {"room": _room, "hold": _hold}


def _shell(x_m: float, y_m: float, height_m: float, colour: Colour) -> tuple[Prop, ...]:
    """Close a rectangle of this inner size with four walls. Those along x cover the corners."""
    along_x = (Part("wall", Box(x_m + 2 * _THICK_M, _THICK_M, height_m), colour),)
    along_y = (Part("wall", Box(_THICK_M, y_m, height_m), colour),)
    half_x, half_y = (x_m + _THICK_M) / 2, (y_m + _THICK_M) / 2
    return (
        Prop("side_left", 0.0, half_y, along_x),
        Prop("side_right", 0.0, -half_y, along_x),
        Prop("side_ahead", half_x, 0.0, along_y),
        Prop("side_behind", -half_x, 0.0, along_y),
    )


def _partitions() -> tuple[Prop, ...]:
    """Free-standing walls. Those on the right hide the rest from the UAV (figure 8.11)."""
    return (
        _wall("wall_long", (-4.7, -2.2), (0.2, -2.2)),
        _wall("wall_corner", (0.2, -2.2), (0.2, -3.6)),
        _wall("wall_bay", (2.6, 6.0), (2.6, 3.2)),
        _wall("wall_slanted", (3.2, -1.2), (5.2, -2.7)),
    )


def _wall(name: str, start: tuple[float, float], end: tuple[float, float]) -> Prop:
    """Build a brick wall between two points of its middle line, and half its thickness beyond both."""
    length = math.hypot(end[0] - start[0], end[1] - start[1])
    yaw = math.atan2(end[1] - start[1], end[0] - start[0])
    middle = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
    return Prop(name, *middle, (Part("wall", Box(length + _THICK_M, _THICK_M, _ROOM_HEIGHT_M), _BRICK),), yaw)


def _clutter() -> tuple[Prop, ...]:
    return (
        _bookshelf(-6.6, 2.4),
        *(
            Prop(f"column_{number}", x, y, (Part("column", Cylinder(radius, 3.5), _BLUE),))
            for number, (x, y, radius) in enumerate(
                (
                    (-0.6, 0.9, 0.40),
                    (5.4, 3.5, 0.40),
                    (-3.2, 4.4, 0.30),
                    (2.6, -4.9, 0.45),
                    (-7.2, -3.7, 0.35),
                )
            )
        ),
        *(
            Prop(f"box_{number}", x, y, (Part("box", Box(along, across, 3.2), _CARDBOARD),), yaw)
            for number, (x, y, along, across, yaw) in enumerate(
                (
                    (-3.6, 1.0, 1.0, 0.8, 0.4),
                    (7.2, 0.3, 1.0, 1.2, 0.0),
                    (0.4, 4.9, 0.9, 0.9, 0.8),
                    (6.9, -5.3, 1.2, 0.6, -0.3),
                    (-3.0, -5.4, 1.6, 0.7, 0.1),
                    (3.0, 0.3, 0.7, 0.5, 1.1),
                )
            )
        ),
    )


def _bookshelf(x_m: float, y_m: float) -> Prop:
    """A bookshelf open towards +x: on the map a "[". A lidar at 2 m does not see its lowest boards."""
    depth, width, height = 0.5, 2.2, 3.2
    side = Box(depth, _BOARD_M, height)
    half = (width - _BOARD_M) / 2
    back = Part(
        "back", Box(_BOARD_M, width, height), _BROWN, centre=((_BOARD_M - depth) / 2, 0.0, height / 2)
    )
    board = Box(depth, width - 2 * _BOARD_M, _BOARD_M)
    return Prop(
        "bookshelf",
        x_m,
        y_m,
        (
            back,
            Part("side_left", side, _BROWN, centre=(0.0, half, height / 2)),
            Part("side_right", side, _BROWN, centre=(0.0, -half, height / 2)),
            *(
                Part(f"board_{number}", board, _BROWN, centre=(0.0, 0.0, z), solid=False)
                for number, z in enumerate((0.05, 0.6, 1.15, 1.7, 2.3, 2.85))
            ),
        ),
    )


def _beams(width_m: float, spacing_m: float) -> tuple[Prop, ...]:
    """Beams on all four sides, symmetrically about the middle of each."""
    props = []
    for side, length, reach, yaw in (
        ("left", HOLD_X_M, HOLD_Y_M / 2, -math.pi / 2),
        ("right", HOLD_X_M, HOLD_Y_M / 2, math.pi / 2),
        ("ahead", HOLD_Y_M, HOLD_X_M / 2, math.pi),
        ("behind", HOLD_Y_M, HOLD_X_M / 2, 0.0),
    ):
        beam = (Part("beam", Box(BEAM_DEPTH_M, width_m, _HOLD_HEIGHT_M), _FRAME_STEEL),)
        out = BEAM_DEPTH_M / 2 - reach  # from the middle of the hold, against the side's inward normal
        count = int((length - width_m) / spacing_m) + 1
        for number in range(count):
            along = (number - (count - 1) / 2) * spacing_m
            x = out * math.cos(yaw) - along * math.sin(yaw)
            y = out * math.sin(yaw) + along * math.cos(yaw)
            props.append(Prop(f"beam_{side}_{number:02d}", x, y, beam, yaw))
    return tuple(props)
