"""Random scans for property tests: rooms, columns, walls with gaps, noise, dropouts, every kind of lidar."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st
from planar_flight import Scene, box

from cepa import CepaParameters, LaserScan2D

COUNTS = (60, 90, 120, 144)


@dataclass(frozen=True)
class Recipe:
    """What a scan is made of."""

    seed: int
    beams_per_turn: float  # a whole number, or the first and the last beam are not as near as the others
    coverage: float  # share of a turn that the lidar sees
    start: float  # rad, direction of the first beam
    descending: bool
    columns: int
    walls: int
    room: bool
    keep_out: float  # m, no surface nearer than this
    noise: float
    dropouts: float  # share of invalid beams

    def scan(self) -> LaserScan2D:
        rng = np.random.default_rng(self.seed)
        increment = 2.0 * math.pi / self.beams_per_turn
        count = max(1, round(self.coverage * self.beams_per_turn))
        angles = self.start + np.arange(count) * increment
        ranges = self._scene(rng).ranges(np.zeros(2), np.stack([np.cos(angles), np.sin(angles)], axis=1))
        ranges = np.maximum(ranges, self.keep_out) + rng.normal(0.0, 1.0, count).clip(-2, 2) * self.noise
        ranges[ranges > 12.0] = np.inf
        ranges[rng.random(count) < self.dropouts] = np.nan
        if self.descending:
            return LaserScan2D(ranges[::-1], angles[-1], -increment, 0.05, 12.0)
        return LaserScan2D(ranges, angles[0], increment, 0.05, 12.0)

    def _scene(self, rng) -> Scene:
        distance = self.keep_out + rng.gamma(2.0, 1.2, self.columns)
        bearing = rng.uniform(-math.pi, math.pi, self.columns)
        radius = rng.uniform(0.05, 0.5, self.columns)
        centres = np.stack([np.cos(bearing), np.sin(bearing)], axis=1) * (distance + radius)[:, None]
        walls = [tuple(rng.uniform(-4.0, 4.0, 4)) for _ in range(self.walls)]
        if self.room:
            walls += box(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(2.6, 8.0))
        return Scene(np.column_stack([centres, radius]), np.array(walls).reshape(-1, 4))


def recipes(nearest=0.55, farthest=1.0):
    """Recipes whose ``keep_out`` lies in this range."""
    return st.builds(
        Recipe,
        seed=st.integers(0, 2**32 - 1),
        beams_per_turn=st.sampled_from(COUNTS),
        coverage=st.sampled_from([1.0, 1.0, 0.75, 2.0 / 3.0, 0.4]),
        start=st.floats(-math.pi, math.pi),
        descending=st.booleans(),
        columns=st.integers(0, 12),
        walls=st.integers(0, 3),
        room=st.booleans(),
        keep_out=st.floats(nearest, farthest),
        noise=st.sampled_from([0.0, 0.013]),
        dropouts=st.sampled_from([0.0, 0.0, 0.02, 0.2]),
    )


velocities = st.tuples(st.floats(0.06, 4.0), st.floats(-math.pi, math.pi)).map(
    lambda polar: (polar[0] * math.cos(polar[1]), polar[0] * math.sin(polar[1]))
)

parameter_sets = st.builds(
    CepaParameters,
    r_lb=st.sampled_from([0.45, 0.5]),
    r_ub=st.sampled_from([0.6, 1.2, 1.5]),
    time_horizon=st.sampled_from([0.5, 1.5, 3.0]),
    k1=st.floats(0.0, 20.0),
    k2=st.floats(0.0, 20.0),
    k3=st.floats(0.0, 5.0),
    k4=st.floats(0.0, 5.0),
    k5=st.floats(0.0, 10.0),
    speed_fractions=st.sampled_from(
        [(1.0, 0.75, 0.5, 0.25), (1.0,), (0.9, 0.3), tuple(np.linspace(0.1, 1.0, 8))]
    ),
    unseen_is_free=st.booleans(),
)


steady_parameter_sets = st.tuples(parameter_sets, st.floats(0.0, 20.0)).map(
    lambda pair: replace(pair[0], k_previous=pair[1])
)
"""The same, with a cost of leaving the last answer's direction."""


def full_turn(recipe: Recipe) -> Recipe:
    """The same with a lidar that sees all around, without dropouts."""
    return replace(recipe, coverage=1.0, dropouts=0.0, descending=False)
