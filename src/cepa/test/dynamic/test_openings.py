"""A small UAV with clouds passes each opening that fits it, near the middle, and no other."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from spatial_flight import LEVEL, NO_SCAN, Boxes

from cepa import CepaParameters, Cloud, Dynamic, Motion
from cepa.dynamic.kernels.response import fly
from cepa.dynamic.observer import response_of
from cepa.dynamic.remembered.field_grid import field_grid_of
from cepa.dynamic.remembered.space_memory import RecalledSpace

RADIUS_M, BELOW_M, ABOVE_M = 0.2, 0.17, 0.05
SMALL = CepaParameters(
    body_radius=RADIUS_M, r_lb=0.22, r_ub=0.4, body_below=BELOW_M, body_above=ABOVE_M, window_m=0.0
)
PERIOD_S, STEP_S, SPEED_M_S, NOISE_M = 0.1, 0.001, 0.8, 0.01
PLATE_X_M, PLATE_M, BEYOND_X_M = 1.6, 0.03, 2.8
LEAVES_S = 7.2
AZIMUTH_RAD, ELEVATION_RAD = np.meshgrid(
    np.radians(np.arange(0.0, 360.0, 2.0)), np.radians(np.arange(-52.0, 52.1, 2.6))
)
DIRECTIONS = np.stack(
    [
        np.cos(ELEVATION_RAD) * np.cos(AZIMUTH_RAD),
        np.cos(ELEVATION_RAD) * np.sin(AZIMUTH_RAD),
        np.sin(ELEVATION_RAD),
    ],
    axis=-1,
).reshape(-1, 3)


def room_with_plate(breadth_m: float, height_m: float, middle: tuple[float, float]) -> Boxes:
    """Return a room of 6 x 3 x 3 m, parted by a plate with an opening around ``middle`` (y, z), m."""
    (y, z), x = middle, (PLATE_X_M, PLATE_X_M + PLATE_M)
    low_y, high_y, low_z, high_z = y - breadth_m / 2, y + breadth_m / 2, z - height_m / 2, z + height_m / 2
    plate = [
        ((x[0], -1.5, 0.0), (x[1], low_y, 3.0)),
        ((x[0], high_y, 0.0), (x[1], 1.5, 3.0)),
        ((x[0], low_y, 0.0), (x[1], high_y, low_z)),
        ((x[0], low_y, high_z), (x[1], high_y, 3.0)),
    ]
    shell = [
        ((-2.0, -1.7, 0.0), (4.0, -1.5, 3.0)),
        ((-2.0, 1.5, 0.0), (4.0, 1.7, 3.0)),
        ((-2.2, -1.7, 0.0), (-2.0, 1.7, 3.0)),
        ((4.0, -1.7, 0.0), (4.2, 1.7, 3.0)),
        ((-2.2, -1.7, 3.0), (4.2, 1.7, 3.2)),
    ]
    return Boxes(np.array(plate + shell))


@dataclass
class Passage:
    """What came of a flight through a plate. positions (n, 3): m, one a cloud."""

    positions: np.ndarray
    clearance_m: float

    @property
    def is_through(self) -> bool:
        return bool(self.positions[-1, 0] > PLATE_X_M + 0.5)

    @property
    def at_plate(self) -> np.ndarray:
        """(y, z) in the plane of the plate, m."""
        x, y, z = self.positions.T
        return np.array([np.interp(PLATE_X_M, x, y), np.interp(PLATE_X_M, x, z)])


def passage(boxes_at, middle, rng, patience_s, parameters=SMALL) -> Passage:
    """Fly along x to BEYOND_X_M by clouds with noise. boxes_at: takes the time in s, returns Boxes."""
    steering = Dynamic(parameters)
    response = response_of(parameters.response, STEP_S)
    position, state, command = np.array([0.0, *middle]), np.zeros((3, 4)), np.zeros(3)
    positions, clearance_m = [position], math.inf
    for number in range(round(patience_s / PERIOD_S)):
        t_s, boxes = number * PERIOD_S, boxes_at(number * PERIOD_S)
        ranges = boxes.ranges(position, DIRECTIONS) + rng.normal(0.0, NOISE_M, len(DIRECTIONS))
        seen = (ranges > 0.1) & (ranges < 60.0)
        cloud = Cloud(DIRECTIONS[seen] * ranges[seen, None], (-0.91, 0.91), 0.1, 60.0)
        to_go = np.array([BEYOND_X_M, *middle]) - position
        reference = 0.9 * to_go * min(1.0, SPEED_M_S / (0.9 * np.linalg.norm(to_go)))
        own = tuple(state[:2, 1].tolist())
        motion = Motion(t_s, tuple(position.tolist()), LEVEL, (*own, float(state[2, 1])), float(reference[2]))
        decision = steering.steer(NO_SCAN, tuple(reference[:2].tolist()), own, motion, cloud)
        climb_m_s = float(reference[2]) if decision.climb_m_s is None else decision.climb_m_s
        late, command = command, np.array([*decision.velocity_xy, climb_m_s])
        state[:, 0] = 0.0
        delay_s = parameters.response.delay_s
        fly(state, np.array([[0.0, 9.0, *late], [delay_s, 9.0, *command]]), 0, 2, 0.0, PERIOD_S, response)
        position = position + state[:, 0]
        positions.append(position)
        clearance_m = min(clearance_m, boxes.clearance(position, RADIUS_M - 0.01, BELOW_M, ABOVE_M))
        if position[0] > BEYOND_X_M - 0.3:
            break
    return Passage(np.array(positions), clearance_m)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
@pytest.mark.table(("breadth_m", "height_m"), [(0.6, 0.8), (0.65, 0.6), (0.6, 2.0)])
def test_it_passes_an_opening_that_fits_near_the_middle(breadth_m, height_m, seed):
    rng = np.random.default_rng(seed)
    middle = rng.uniform(-0.5, 0.5), rng.uniform(1.3, 1.7)
    room = room_with_plate(breadth_m, height_m, middle)
    flown = passage(lambda t_s: room, middle, rng, patience_s=20.0)
    assert flown.is_through
    assert abs(flown.at_plate[0] - middle[0]) < 0.04
    assert flown.clearance_m > 0.05


def test_the_reference_may_miss_the_middle():
    rng, middle = np.random.default_rng(7), (0.1, 1.5)
    room = room_with_plate(0.6, 0.8, middle)
    flown = passage(lambda t_s: room, (0.16, 1.5), rng, patience_s=20.0)
    assert flown.is_through
    assert abs(flown.at_plate[0] - middle[0]) < 0.04


@pytest.mark.table(("breadth_m", "height_m"), [(0.4, 0.8), (0.6, 0.25)])
def test_it_stops_before_an_opening_that_does_not_fit(breadth_m, height_m):
    rng, middle = np.random.default_rng(1), (0.1, 1.5)
    room = room_with_plate(breadth_m, height_m, middle)
    flown = passage(lambda t_s: room, middle, rng, patience_s=6.0)
    assert not flown.is_through
    assert flown.clearance_m > 0.02


def person(t_s: float):
    """Return a person who stands behind the opening, and walks aside after LEAVES_S."""
    y = 0.1 + 0.9 * max(0.0, t_s - LEAVES_S)
    return ((PLATE_X_M + 0.35, y - 0.25, 0.0), (PLATE_X_M + 0.65, y + 0.25, 1.8))


def hose(t_s: float):
    """Return a hose that swings right behind the opening, and hangs aside after LEAVES_S."""
    y = 0.1 + 0.6 * math.sin(2.0 * math.pi * min(t_s, LEAVES_S) / 3.2)
    return ((PLATE_X_M + 0.25, y - 0.03, 0.3), (PLATE_X_M + 0.31, y + 0.03, 3.0))


@pytest.mark.parametrize("moving", [person, pytest.param(hose, marks=pytest.mark.long)])
def test_it_waits_while_something_is_behind_the_opening(moving):
    rng, middle = np.random.default_rng(3), (0.1, 1.5)
    room = room_with_plate(0.6, 0.8, middle)

    def boxes_at(t_s):
        return Boxes(np.concatenate((room.corners, [moving(t_s)])))

    flown = passage(boxes_at, middle, rng, patience_s=26.0)
    assert flown.clearance_m > 0.03
    assert flown.positions[: round(LEAVES_S / PERIOD_S), 0].max() < PLATE_X_M + 0.1
    assert flown.is_through


def test_what_leaves_more_than_a_cell_keeps_the_usual_grid():
    usual = field_grid_of(CepaParameters())
    assert (usual.cell_m, usual.side, usual.layer_m) == (0.1, 151, 0.15)
    fine = field_grid_of(SMALL)
    assert (fine.cell_m, fine.side, fine.layer_m) == (0.03, 151, 0.1)
    assert field_grid_of(CepaParameters(body_radius=0.45, window_m=0.0)).cell_m == pytest.approx(0.05)
    assert field_grid_of(CepaParameters(body_radius=0.45)) == usual  # a search needs the whole window


def test_a_height_beyond_the_layers_is_open_if_the_outermost_layer_is():
    # Heights of -0.7 to 0.7 m; the reference asks for 1 m
    grid, heights_m = field_grid_of(SMALL), 0.1 * (np.arange(15) - 7)
    known = np.empty((0, 3)), np.empty(0, np.bool_), np.full((15, grid.side, grid.side), 0.43)
    rest = np.zeros((15, 75, 75), np.uint8), np.empty(0), heights_m, np.abs(heights_m - 1.0), 1.0
    space = RecalledSpace(*known, *rest, grid)
    assert space.open_height_m(np.array([1.0, 0.0]), 0.0, 0.22) == 1.0
    space.distance[-1] = 0.0
    assert 0.45 < space.open_height_m(np.array([1.0, 0.0]), 0.0, 0.22) < 0.55  # the layer amid open ones


def test_in_an_opening_it_flies_within_the_open_layer_towards_the_height_asked_for():
    # One layer is open, at 0.1 m; the reference asks for -0.1 m
    grid, heights_m = field_grid_of(SMALL), 0.1 * (np.arange(15) - 7)
    known = np.empty((0, 3)), np.empty(0, np.bool_), np.zeros((15, grid.side, grid.side))
    rest = np.zeros((15, 75, 75), np.uint8), np.empty(0), heights_m, np.abs(heights_m + 0.1), -0.1
    space = RecalledSpace(*known, *rest, grid)
    space.distance[8] = 0.25
    height_m = space.open_height_m(np.array([1.0, 0.0]), 0.0, 0.22)
    assert 0.05 < height_m < 0.1  # a layer is 0.1 m thick
