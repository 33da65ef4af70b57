"""An office: rooms in rows, with doors between them by which every room can be reached."""

from __future__ import annotations

import numpy as np

from flights.worlds.drawn.materials import LINOLEUM, PLASTER
from flights.worlds.writer import Box, Part, Prop, write_world

DOOR_M = 1.2
ROOM_X_M, ROOM_Y_M, ROWS = 6.0, 5.0, 3
"""About how large a room is, and how many stand side by side."""
SPARE_DOORS = 0.35
"""Share of the walls that have a door besides those that connect all rooms."""
_BEYOND_M = 3.0
_WALL_M, _HEIGHT_M = 0.12, 4.0
_JAMB_M = 0.4
"""Least wall beside a door."""


def office_sdf(rng: np.random.Generator, distance_m: float) -> str:
    """Return an office around the x axis, from behind the start to beyond the goal.

    The doors make a spanning tree of the rooms (Kruskal's algorithm in random order) and some more.
    """
    x_edges = _edges(rng, -_BEYOND_M, distance_m + _BEYOND_M, ROOM_X_M)
    y_edges = _edges(rng, -ROWS * ROOM_Y_M / 2, ROWS * ROOM_Y_M / 2, ROOM_Y_M)
    columns = len(x_edges) - 1
    rooms = {(i, j): (i, j) for i in range(columns) for j in range(ROWS)}  # to one of those it is joined to
    props = _outer_walls(x_edges, y_edges)
    inner = [((i, j), (i + 1, j)) for i in range(columns - 1) for j in range(ROWS)]
    inner += [((i, j), (i, j + 1)) for i in range(columns) for j in range(ROWS - 1)]
    for number in rng.permutation(len(inner)):
        room, next_room = inner[number]
        joined, other = rooms[room], rooms[next_room]
        has_door = joined != other or rng.random() < SPARE_DOORS
        rooms = {name: joined if of == other and has_door else of for name, of in rooms.items()}
        i, j = room
        if next_room[0] > i:
            line = (x_edges[i + 1], y_edges[j]), (x_edges[i + 1], y_edges[j + 1])
        else:
            line = (x_edges[i], y_edges[j + 1]), (x_edges[i + 1], y_edges[j + 1])
        props += _wall(f"wall_{number}", np.array(line), rng if has_door else None)
    return write_world("office", "An office drawn at random.", LINOLEUM, tuple(props))


def _edges(rng: np.random.Generator, low_m: float, high_m: float, size_m: float) -> np.ndarray:
    """Return where rooms of about this size end between two limits; an inner edge is moved by up to 0.1."""
    number = round((high_m - low_m) / size_m)
    edges = np.linspace(low_m, high_m, number + 1)
    edges[1:-1] += rng.uniform(-0.1, 0.1, number - 1) * size_m
    return edges


def _outer_walls(x_edges: np.ndarray, y_edges: np.ndarray) -> list[Prop]:
    (x0, x1), (y0, y1) = x_edges[[0, -1]], y_edges[[0, -1]]
    lines = {
        "behind": ((x0, y0), (x0, y1)),
        "ahead": ((x1, y0), (x1, y1)),
        "right": ((x0, y0), (x1, y0)),
        "left": ((x0, y1), (x1, y1)),
    }
    return [prop for name, line in lines.items() for prop in _wall(name, np.array(line))]


def _wall(name: str, line: np.ndarray, rng: np.random.Generator | None = None) -> list[Prop]:
    """Return a wall along a line (2, 2: start and end, along x or y); rng: draws where its door is."""
    along = line[1] - line[0]
    length = float(np.abs(along).sum())
    pieces = [(0.0, length)]
    if rng is not None:
        free = _WALL_M / 2 + _JAMB_M
        door = rng.uniform(free, length - free - DOOR_M)
        pieces = [(0.0, door), (door + DOOR_M, length)]
    props = []
    for number, (begin, end) in enumerate(pieces):
        x, y = line[0] + along * (begin + end) / (2 * length)
        size_x, size_y = np.where(along != 0.0, end - begin, _WALL_M)
        props.append(Prop(f"{name}_{number}", x, y, (Part("wall", Box(size_x, size_y, _HEIGHT_M), PLASTER),)))
    return props
