"""A cargo hold with decks, frames, a hatch, a ladder and stanchions: what a map of a plane cannot show.

Aft is -x, port is +y. The tank top is the ground, z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_basics.checks import check_limits, limited
from flights.errors import ScenarioError
from flights.worlds.cargo import cargo
from flights.worlds.steel import FITTING, FRAME, SHELL, box, places
from flights.worlds.writer import Colour, Cylinder, Part, Prop, Surroundings, write_world

THICK_M = 0.2
"""Of the shell, so that nothing passes through it within a time step."""
PLATE_M, FLANGE_M = 0.05, 0.20
"""Thickness of webs, and width of their flanges."""
RAIL_M, RUNG_M, RUNG_STEP_M, LADDER_M, STANDS_OFF_M = 0.06, 0.03, 0.30, 0.40, 0.20
STANCHION_RADIUS_M = 0.15
_FLOOR = Surroundings(Colour(0.70, 0.68, 0.66), camera=(-12.0, -7.0, 8.0, 0.0, 0.4, 0.5))


@dataclass(frozen=True)
class Hold3DParameters:
    """Sizes in m. The hatch is in the middle of the deck, closed by its cover.

    Raises:
        ScenarioError: a size is not positive, or the hatch or the frames do not fit.
    """

    length_m: float = limited(30.0, above=0.0)
    breadth_m: float = limited(20.0, above=0.0)
    height_m: float = limited(10.0, above=0.0)
    frame_spacing_m: float = limited(3.0, above=0.0)
    frame_depth_m: float = limited(0.5, above=0.0)
    beam_depth_m: float = limited(0.6, above=0.0)
    hatch_length_m: float = limited(12.0, above=0.0)
    hatch_breadth_m: float = limited(8.0, above=0.0)
    coaming_m: float = limited(1.0, above=0.0)
    """How far the hatch's coaming stands above the deck. Half as much hangs below it."""

    def __post_init__(self) -> None:
        check_limits(self, ScenarioError, "hold_3d: {}")
        room = min(self.length_m - self.hatch_length_m, self.breadth_m - self.hatch_breadth_m)
        if room < 4.0 * self.frame_depth_m:
            raise ScenarioError("hold_3d: the hatch does not fit between the frames. Make it smaller.")
        if self.frame_spacing_m > self.length_m / 2 or self.beam_depth_m > self.height_m / 2:
            raise ScenarioError("hold_3d: frames and beams need less than half the hold's length and height.")


def hold_3d(parameters: Hold3DParameters | None = None) -> str:
    """Return the hold as the text of a world file."""
    p = parameters or Hold3DParameters()
    return write_world("hold_3d", f"{_comment(p)}.", _FLOOR, _props(p))


def hold_3d_cargo() -> str:
    """Return the hold of the default sizes with cargo left in it."""
    p = Hold3DParameters()
    return write_world("hold_3d_cargo", f"{_comment(p)}, and cargo left in it.", _FLOOR, _props(p) + cargo())


def _comment(p: Hold3DParameters) -> str:
    return (
        f"A cargo hold, {p.length_m:g} x {p.breadth_m:g} x {p.height_m:g} m, with frames every "
        f"{p.frame_spacing_m:g} m, deck beams, hatch coaming, ladder and stanchions"
    )


def _props(p: Hold3DParameters) -> tuple[Prop, ...]:
    return tuple(
        Prop(name, 0.0, 0.0, parts)
        for name, parts in (
            ("shell", _shell(p)),
            ("frames", (*_side_frames(p), *_bulkhead_stiffeners(p))),
            ("beams", _beams(p)),
            ("coaming", _coaming(p)),
            ("ladder", _ladder(p)),
            ("stanchions", _stanchions(p)),
        )
    )


def _shell(p: Hold3DParameters) -> tuple[Part, ...]:
    """Sides, bulkheads, the deck around the hatch, and the hatch's cover."""
    half_x, half_y, hatch_x, hatch_y = _halves(p)
    out_x, out_y, z = half_x + THICK_M, half_y + THICK_M, (0.0, p.height_m)
    deck, cover = (p.height_m, p.height_m + THICK_M), p.height_m + p.coaming_m
    return (
        box("side_port", (-out_x, out_x), (half_y, out_y), z, SHELL),
        box("side_starboard", (-out_x, out_x), (-out_y, -half_y), z, SHELL),
        box("bulkhead_fore", (half_x, out_x), (-half_y, half_y), z, SHELL),
        box("bulkhead_aft", (-out_x, -half_x), (-half_y, half_y), z, SHELL),
        box("deck_port", (-out_x, out_x), (hatch_y, out_y), deck, SHELL),
        box("deck_starboard", (-out_x, out_x), (-out_y, -hatch_y), deck, SHELL),
        box("deck_fore", (hatch_x, out_x), (-hatch_y, hatch_y), deck, SHELL),
        box("deck_aft", (-out_x, -hatch_x), (-hatch_y, hatch_y), deck, SHELL),
        box("cover", (-hatch_x, hatch_x), (-hatch_y, hatch_y), (cover, cover + THICK_M), SHELL),
    )


def _side_frames(p: Hold3DParameters) -> list[Part]:
    """Webs with flanges on both sides, from the tank top to the deck."""
    half_y, z = p.breadth_m / 2, (0.0, p.height_m)
    parts = []
    for number, x in enumerate(places(p.length_m, p.frame_spacing_m)):
        for name, side in (("port", 1.0), ("starboard", -1.0)):
            root, edge = side * half_y, side * (half_y - p.frame_depth_m)
            label = f"{name}_{number:02d}"
            parts += [
                box(f"web_{label}", _about(x, PLATE_M), _between(root, edge), z, FRAME),
                box(f"flange_{label}", _about(x, FLANGE_M), _between(edge, edge - side * PLATE_M), z, FRAME),
            ]
    return parts


def _bulkhead_stiffeners(p: Hold3DParameters) -> list[Part]:
    half_x, depth, z = p.length_m / 2, p.frame_depth_m / 2, (0.0, p.height_m)
    return [
        box(
            f"stiffener_{name}_{number:02d}",
            _between(side * half_x, side * (half_x - depth)),
            _about(y, PLATE_M),
            z,
            FRAME,
        )
        for number, y in enumerate(places(p.breadth_m, p.frame_spacing_m / 2))
        for name, side in (("fore", 1.0), ("aft", -1.0))
    ]


def _beams(p: Hold3DParameters) -> tuple[Part, ...]:
    """Deck beams at the frames, cut where the hatch is."""
    half_y, hatch_x, hatch_y = p.breadth_m / 2, p.hatch_length_m / 2, p.hatch_breadth_m / 2
    z = (p.height_m - p.beam_depth_m, p.height_m)
    parts = []
    for number, x in enumerate(places(p.length_m, p.frame_spacing_m)):
        across = [(-half_y, half_y)]
        if abs(x) < hatch_x + FLANGE_M:
            across = [(-half_y, -hatch_y - PLATE_M), (hatch_y + PLATE_M, half_y)]
        for piece, y in enumerate(across):
            low = (z[0] - PLATE_M, z[0])
            parts += [
                box(f"web_{number:02d}_{piece}", _about(x, PLATE_M), y, z, FRAME),
                box(f"flange_{number:02d}_{piece}", _about(x, FLANGE_M), y, low, FRAME),
            ]
    return tuple(parts)


def _coaming(p: Hold3DParameters) -> tuple[Part, ...]:
    """Plates around the hatch, from below the deck up to the cover."""
    _, _, x, y = _halves(p)
    z = (p.height_m - p.coaming_m / 2, p.height_m + p.coaming_m)
    long = (-x - PLATE_M, x + PLATE_M)
    return (
        box("port", long, (y, y + PLATE_M), z, FITTING),
        box("starboard", long, (-y - PLATE_M, -y), z, FITTING),
        box("fore", (x, x + PLATE_M), (-y, y), z, FITTING),
        box("aft", (-x - PLATE_M, -x), (-y, y), z, FITTING),
    )


def _ladder(p: Hold3DParameters) -> tuple[Part, ...]:
    """A vertical ladder at the aft bulkhead, midway between two of its stiffeners."""
    x = -p.length_m / 2 + p.frame_depth_m / 2 + STANDS_OFF_M
    lines = [*places(p.breadth_m, p.frame_spacing_m / 2)]
    y = (lines[len(lines) // 2] + lines[len(lines) // 2 - 1]) / 2 if len(lines) > 1 else 0.0
    rails = tuple(
        box(
            f"rail_{name}",
            _about(x, RAIL_M),
            _about(y + side * LADDER_M / 2, RAIL_M),
            (0.0, p.height_m),
            FITTING,
        )
        for name, side in (("port", 1.0), ("starboard", -1.0))
    )
    rungs = tuple(
        box(
            f"rung_{number:02d}",
            _about(x, RUNG_M),
            _about(y, LADDER_M - RAIL_M),
            _about(z, RUNG_M),
            FITTING,
        )
        for number, z in enumerate(np.arange(RUNG_STEP_M, p.height_m - RUNG_STEP_M / 2, RUNG_STEP_M).tolist())
    )
    return rails + rungs


def _stanchions(p: Hold3DParameters) -> tuple[Part, ...]:
    """Three pillars below the deck, none in another's shadow."""
    _, half_y, hatch_x, _ = _halves(p)
    beyond_x = hatch_x + 0.4 * (p.length_m / 2 - hatch_x)
    feet = ((-beyond_x, 0.25 * half_y), (beyond_x, -0.35 * half_y), (0.0, -0.7 * half_y))
    shape = Cylinder(STANCHION_RADIUS_M, p.height_m)
    return tuple(
        Part(f"stanchion_{number}", shape, FITTING, (x, y, p.height_m / 2))
        for number, (x, y) in enumerate(feet)
    )


def _halves(p: Hold3DParameters) -> tuple[float, float, float, float]:
    return p.length_m / 2, p.breadth_m / 2, p.hatch_length_m / 2, p.hatch_breadth_m / 2


def _about(middle_m: float, width_m: float) -> tuple[float, float]:
    return middle_m - width_m / 2, middle_m + width_m / 2


def _between(a_m: float, b_m: float) -> tuple[float, float]:
    return min(a_m, b_m), max(a_m, b_m)
