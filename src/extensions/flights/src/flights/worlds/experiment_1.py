"""The four worlds of Experiment 1 (thesis, figures 8.1 and 8.2), drawn by code.

Start is the origin, the goal lies 40 m ahead on the x axis, and the flight is at 2 m. No solid ends between
1.2 m and 2.4 m over the floor. So a horizontal lidar at 2 m sees every obstacle.
"""

from __future__ import annotations

import math
from typing import Callable, Iterator, Sequence

import numpy as np

from flights.worlds.writer import Box, Colour, Cylinder, Part, Prop, Sphere, Surroundings, write_world

GOAL_X_M = 40.0

_BARK = Colour(0.55, 0.40, 0.27)
_LEAVES = Colour(0.33, 0.58, 0.28, transparency=0.5)
_GRASS = Surroundings(Colour(0.80, 0.87, 0.72))
_LINOLEUM = Surroundings(Colour(0.90, 0.89, 0.86), camera=(-10.0, 0.0, 12.0, 0.0, 0.6, 0.0))
_PLASTER = Colour(0.88, 0.86, 0.80)
_WOOD = Colour(0.60, 0.42, 0.26)
_STEEL = Colour(0.45, 0.50, 0.56)
_CARDBOARD = Colour(0.74, 0.60, 0.42)
_BRICK = Colour(0.66, 0.36, 0.28)
_CONCRETE = Colour(0.62, 0.62, 0.60)

_WALL_THICKNESS_M = 0.15
_WALL_HEIGHT_M = 3.0
_HALF_WIDTH_M = 1.5  # of the hallway: 3 m between its walls' faces


def _empty(rng: np.random.Generator) -> str:
    return write_world("empty", "Scenario 1: an empty field, 40 m from start to goal.", _GRASS, _pads())


def _sparse(rng: np.random.Generator) -> str:
    """Scatter columns, crates and short walls at least 5 m apart, five of them on the straight way."""
    on_the_way = [(8.0, 0.3), (15.0, -0.6), (21.5, 0.5), (28.0, -0.2), (34.0, 0.4)]
    spots = _scatter(rng, 32, x_range=(5.0, 37.0), y_range=(-14.0, 14.0), spacing_m=4.6, taken=on_the_way)
    props = tuple(_obstacle(rng, index, *spot) for index, spot in enumerate(spots))
    comment = "Scenario 2: a field with obstacles sparsely spread, 40 m from start to goal."
    return write_world("sparse", comment, _GRASS, _pads() + props)


def _forest(rng: np.random.Generator) -> str:
    """Plant trunks of 0.12 to 0.3 m radius, at least 2.6 m from centre to centre."""
    spots = _scatter(rng, 140, x_range=(3.5, 36.5), y_range=(-16.0, 16.0), spacing_m=2.6, taken=())
    props = tuple(_tree(rng, index, *spot) for index, spot in enumerate(spots))
    comment = "Scenario 3: a forest, 40 m from start to goal."
    return write_world("forest", comment, _GRASS, _pads() + props)


def _hallway(rng: np.random.Generator) -> str:
    comment = "Scenario 4: a hallway 3 m wide with rooms to both sides, 40 m from start to goal."
    return write_world("hallway", comment, _LINOLEUM, _pads() + _hallway_walls() + _rooms() + _furniture())


MAKERS: dict[str, Callable[[np.random.Generator], str]] = {
    "empty": _empty,
    "sparse": _sparse,
    "forest": _forest,
    "hallway": _hallway,
}
"""In the order of the thesis's table 8.1."""


def _pads() -> tuple[Prop, ...]:
    """Mark start and goal on the floor; the marks are visible, but nothing can touch them."""
    pads = (("start_pad", 0.0, Colour(0.20, 0.45, 0.75)), ("goal_pad", GOAL_X_M, Colour(0.80, 0.25, 0.20)))
    return tuple(
        Prop(name, x, 0.0, (Part("disc", Cylinder(0.6, 0.01), colour, solid=False),))
        for name, x, colour in pads
    )


def _scatter(
    rng: np.random.Generator,
    most: int,
    x_range: tuple[float, float],
    y_range: tuple[float, float],
    spacing_m: float,
    taken: Sequence[tuple[float, float]],
) -> list[tuple[float, float]]:
    """Draw up to `most` random places, at a distance from each other and 3 m from start and goal."""
    spots = list(taken)
    for _ in range(20_000):
        x, y = round(float(rng.uniform(*x_range)), 2), round(float(rng.uniform(*y_range)), 2)
        free_of_ends = min(math.hypot(x, y), math.hypot(x - GOAL_X_M, y)) >= 3.0
        if free_of_ends and all(math.hypot(x - a, y - b) >= spacing_m for a, b in spots):
            spots.append((x, y))
        if len(spots) == most:
            break
    return spots


def _tree(rng: np.random.Generator, index: int, x: float, y: float) -> Prop:
    radius = round(float(rng.uniform(0.12, 0.30)), 3)
    height = round(float(rng.uniform(2.6, 3.4)), 2)
    crown = round(float(rng.uniform(0.40, 0.65)), 2)
    trunk = Part("trunk", Cylinder(radius, height), _BARK)
    leaves = Part("crown", Sphere(crown), _LEAVES, centre=(0.0, 0.0, height + 0.4 * crown), solid=False)
    return Prop(f"tree_{index:03d}", x, y, (trunk, leaves))


def _obstacle(rng: np.random.Generator, index: int, x: float, y: float) -> Prop:
    kind = int(rng.integers(3))
    size = round(float(rng.uniform(0.0, 1.0)), 2)
    yaw = round(float(rng.uniform(-math.pi, math.pi)), 2)
    if kind == 0:
        part = Part("column", Cylinder(0.2 + 0.4 * size, 4.0), _CONCRETE)
    elif kind == 1:
        part = Part("crate", Box(0.8 + 0.8 * size, 0.8 + 0.4 * size, 2.6), _CARDBOARD)
    else:
        part = Part("wall", Box(1.4 + 1.2 * size, 0.25, 2.8), _BRICK)
    return Prop(f"{part.name}_{index:02d}", x, y, (part,), yaw)


def _wall(name: str, start: tuple[float, float], end: tuple[float, float]) -> Prop:
    """Build a wall between two points of its middle line."""
    length = math.hypot(end[0] - start[0], end[1] - start[1])
    yaw = math.atan2(end[1] - start[1], end[0] - start[0])
    shape = Box(length + _WALL_THICKNESS_M, _WALL_THICKNESS_M, _WALL_HEIGHT_M)
    middle_x, middle_y = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
    return Prop(name, middle_x, middle_y, (Part("wall", shape, _PLASTER),), yaw)


# The hallway's middle line: straight, a bend to the left, a hall with a pillar, then back. (x, y of the
# middle line, half the width between the walls' faces)
_STATIONS = (
    (-2.5, 0.0, _HALF_WIDTH_M),
    (10.5, 0.0, _HALF_WIDTH_M),
    (13.5, 1.0, _HALF_WIDTH_M),
    (18.0, 1.0, _HALF_WIDTH_M),
    (20.0, 0.5, 3.5),
    (25.0, 0.5, 3.5),
    (27.0, 0.0, _HALF_WIDTH_M),
    (42.5, 0.0, _HALF_WIDTH_M),
)
XY = tuple[float, float]
_DOORS = {"left": ((4.0, 5.0), (15.0, 16.0), (31.5, 32.5)), "right": ((6.5, 7.5), (15.5, 16.5), (35.0, 36.0))}
_OUTER_Y_M = 6.5
_PILLAR = Prop("pillar", 22.5, 0.3, (Part("pillar", Cylinder(0.3, _WALL_HEIGHT_M), _CONCRETE),))


def _hallway_walls() -> tuple[Prop, ...]:
    """Build both sides of the hallway with gaps at the doors, and close both ends."""
    props: list[Prop] = [_PILLAR]
    offset = _WALL_THICKNESS_M / 2
    for side, sign in (("left", 1.0), ("right", -1.0)):
        line = [(x, y + sign * (half + offset)) for x, y, half in _STATIONS]
        for start, end in _without_doors(line, _DOORS[side]):
            props.append(_wall(f"hallway_{side}_{len(props):02d}", start, end))
    for name, x in (("end_start", _STATIONS[0][0]), ("end_goal", _STATIONS[-1][0])):
        props.append(_wall(name, (x, -_OUTER_Y_M), (x, _OUTER_Y_M)))
    return tuple(props)


def _without_doors(line: Sequence[XY], doors: Sequence[tuple[float, float]]) -> Iterator[tuple[XY, XY]]:
    """Cut the doors' x ranges out of a polyline's segments along x; yield (start, end) of the rest."""
    for start, end in zip(line, line[1:]):
        at_x = start[0]
        for door_start, door_end in doors:
            if start[0] < door_start and door_end < end[0]:
                yield (at_x, start[1]), (door_start, start[1])
                at_x = door_end
        yield (at_x, start[1]), end


def _rooms() -> tuple[Prop, ...]:
    """Add the outer walls, the partitions between the rooms, the doors' leaves and two fire-door frames."""
    first_x, last_x = _STATIONS[0][0], _STATIONS[-1][0]
    inner = _HALF_WIDTH_M + _WALL_THICKNESS_M
    props = [
        _wall("outer_left", (first_x, _OUTER_Y_M), (last_x, _OUTER_Y_M)),
        _wall("outer_right", (first_x, -_OUTER_Y_M), (last_x, -_OUTER_Y_M)),
    ]
    for number, x in enumerate((8.5, 29.0, 36.5)):
        props.append(_wall(f"partition_left_{number}", (x, inner), (x, _OUTER_Y_M)))
    for number, x in enumerate((3.0, 10.5, 29.5)):
        props.append(_wall(f"partition_right_{number}", (x, -_OUTER_Y_M), (x, -inner)))
    leaf = (Part("leaf", Box(0.05, 0.95, 2.4), _WOOD, centre=(0.0, 0.475, 1.2)),)
    props.append(Prop("door_left_0", 4.0, inner, leaf))
    props.append(Prop("door_left_2", 31.5, inner, leaf))
    props.append(Prop("door_right_0", 7.5, -inner, leaf, math.pi))
    props.append(Prop("door_right_2", 36.0, -inner, leaf, math.pi))
    props.extend(_door_frame(f"door_frame_{number}", x) for number, x in enumerate((9.0, 29.8)))
    return tuple(props)


def _door_frame(name: str, x: float) -> Prop:
    """Narrow the hallway to a doorway 2.2 m wide and 2.7 m high."""
    jamb = Box(0.12, 0.4, _WALL_HEIGHT_M)
    lintel = Box(0.12, 2.2, 0.3)
    return Prop(
        name,
        x,
        0.0,
        (
            Part("jamb_left", jamb, _STEEL, centre=(0.0, 1.3, _WALL_HEIGHT_M / 2)),
            Part("jamb_right", jamb, _STEEL, centre=(0.0, -1.3, _WALL_HEIGHT_M / 2)),
            Part("lintel", lintel, _STEEL, centre=(0.0, 0.0, _WALL_HEIGHT_M - 0.15)),
        ),
    )


def _furniture() -> tuple[Prop, ...]:
    """Put cabinets along the hallway's walls, boxes to fly over, and furniture into the rooms."""
    cabinet = (Part("cabinet", Box(0.9, 0.4, 2.4), _STEEL),)
    bookcase = (Part("bookcase", Box(1.2, 0.35, 2.4), _WOOD),)
    box = (Part("box", Box(0.6, 0.5, 0.5), _CARDBOARD),)
    table = (
        Part("top", Box(1.6, 0.8, 0.05), _WOOD, centre=(0.0, 0.0, 0.725)),
        Part("leg_left", Box(0.06, 0.7, 0.7), _STEEL, centre=(-0.7, 0.0, 0.35)),
        Part("leg_right", Box(0.06, 0.7, 0.7), _STEEL, centre=(0.7, 0.0, 0.35)),
    )
    against_the_wall = _HALF_WIDTH_M - 0.2
    return (
        Prop("cabinet_0", 6.5, against_the_wall, cabinet),
        Prop("cabinet_1", 2.5, -against_the_wall, cabinet),
        Prop("cabinet_2", 16.8, 1.0 + against_the_wall, cabinet),
        Prop("cabinet_3", 34.0, -against_the_wall, cabinet),
        Prop("bookcase_0", 38.0, against_the_wall + 0.025, bookcase),
        Prop("bookcase_1", 22.5, 3.8, bookcase),
        Prop("box_0", 5.2, -1.2, box),
        Prop("box_1", 28.5, 1.2, box),
        Prop("box_2", 32.5, -1.2, box, 0.3),
        Prop("table_0", 1.5, 4.5, table),
        Prop("table_1", 6.5, 4.8, table, math.pi / 2),
        Prop("table_2", 6.5, -4.5, table, 0.2),
        Prop("table_3", 15.0, -4.2, table),
        Prop("table_4", 33.0, 4.5, table, 0.1),
        Prop("table_5", 34.0, -4.6, table, math.pi / 2),
        Prop("bookcase_2", 12.0, 6.2, bookcase),
        Prop("bookcase_3", 17.0, -6.2, bookcase),
        Prop("bookcase_4", 40.0, -6.2, bookcase),
    )
