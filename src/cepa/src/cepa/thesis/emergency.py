"""The emergency avoidance: flee from obstacles within r_LB (thesis 6.1.2), but not into others (6.2.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterator

import numpy as np

from cepa.decision import Reason, Vector2
from cepa.parameters import CepaParameters
from cepa.scan import Beams, Grid
from cepa.thesis.cushion import stopping_distance
from cepa.thesis.kernels.emergency import (
    direction_is_safe,
    emergency_edges,
    k_filter,
    safe_directions,
    safe_directions_one_by_one,
    sum_of_intrusions,
)

UNLIMITED_M = 1e9
"""Farther than any lidar sees. It is finite, so a beam without a return (inf) lies beyond it."""


def is_emergency(beams: Beams, grid: Grid, parameters: CepaParameters, v_uav: Vector2) -> bool:
    """Whether anything seen is within r_LB (equation 6.4 would forbid every direction).

    With ``velocity_aware_emergency`` also what the UAV cannot brake for.
    """
    if not parameters.velocity_aware_emergency:
        return beams.nearest <= parameters.r_lb
    return bool((beams.ranges <= edges(beams, grid, parameters, v_uav)).any())


def edges(beams: Beams, grid: Grid, parameters: CepaParameters, v_uav: Vector2) -> np.ndarray:
    """Return the ranges (N,) in m within which an obstacle is an emergency."""
    r_lb, speed = float(parameters.r_lb), math.hypot(*v_uav)
    if not parameters.velocity_aware_emergency or speed == 0.0:
        return np.full(grid.count, r_lb)
    angle = math.atan2(v_uav[1], v_uav[0]) - beams.angle_0
    stopping = stopping_distance(speed, parameters.braking_deceleration, parameters.braking_latency)
    stopping = min(stopping, UNLIMITED_M)
    towards = math.cos(angle), math.sin(angle)
    return emergency_edges(grid.cos, grid.sin, *towards, stopping, r_lb, float(parameters.body_radius))


@dataclass(frozen=True)
class Flight:
    """A proposed flight from danger, relative to beam 0."""

    angle: float
    """rad; meaningless while ``agreement`` is 0."""
    speed: float
    """m/s"""
    agreement: float = 1.0
    """1: all intrusions push one way; 0: they cancel out."""

    def velocity(self, angle_0: float) -> Vector2:
        """Return the velocity in the scan's frame, m/s."""
        return self.speed * math.cos(self.angle + angle_0), self.speed * math.sin(self.angle + angle_0)


def original_flight(beams: Beams, grid: Grid, parameters: CepaParameters, v_uav: Vector2) -> Flight:
    """Return the sum of the intrusions into the circle of r_LB, after the K filter (thesis 6.1.2).

    ``v_uav``: the UAV's own velocity in the scan's frame, m/s; with ``velocity_aware_emergency`` the circle
    bulges along it.
    """
    filtered = k_filter(beams.ranges, float(parameters.k_filter), grid.increment)
    zone = edges(beams, grid, parameters, v_uav)
    x, y, total = sum_of_intrusions(filtered, grid.cos, grid.sin, zone, grid.increment)
    length = math.hypot(x, y)
    if length <= 1e-9 * total:
        return Flight(0.0, 0.0, 0.0)
    speed = min(max(parameters.emergency_gain * length, parameters.v_min), parameters.v_max)
    return Flight(math.atan2(y, x), speed, length / total)


def improved_flight(
    flight: Flight, beams: Beams, grid: Grid, parameters: CepaParameters, v_uav: Vector2
) -> tuple[Flight | None, Reason]:
    """Return (flight, reason): ``flight`` if it is safe, else one into an open section, else None.

    ``v_uav``: the UAV's own velocity in the scan's frame, m/s. It decides between sections that are equally
    good. Otherwise noise would make the UAV switch between them.
    """
    eligible = beams.seen | parameters.unseen_is_free
    cancelled = flight.agreement <= parameters.emergency_cancellation
    if not cancelled and _is_safe(flight.angle, beams, eligible, grid, parameters):
        return flight, Reason.EMERGENCY_SUM
    corridor = float(parameters.body_radius), float(parameters.emergency_lookahead)
    judge = safe_directions if grid.is_even else safe_directions_one_by_one
    safe = judge(beams.ranges, eligible, grid.cos, grid.sin, *corridor)
    sections = open_sections(safe)
    proposal = None if cancelled else flight.angle
    speed = _speed_without_proposal(flight, parameters) if cancelled else flight.speed
    while sections:
        section = _choose(sections, proposal, grid, parameters, v_uav, beams.angle_0)
        for angle in section.from_the_middle(grid):
            if _is_safe(angle, beams, eligible, grid, parameters):
                return Flight(angle, speed), Reason.EMERGENCY_OPEN_SECTION
        sections.remove(section)
    return None, Reason.BLOCKED


def _speed_without_proposal(flight: Flight, parameters: CepaParameters) -> float:
    """Return a speed for a sum that cancels out, which gives neither a direction nor a speed."""
    return max(flight.speed, parameters.v_min) if parameters.v_min > 0.0 else parameters.v_max


@dataclass(frozen=True)
class Section:
    """A run of safe directions."""

    first: int
    """Its first beam."""
    beams: int
    """Number of beams."""

    def middle(self, grid: Grid) -> float:
        """Return the angle in its middle, rad relative to beam 0."""
        return (self.first + 0.5 * (self.beams - 1)) * grid.increment

    def from_the_middle(self, grid: Grid) -> Iterator[float]:
        """Yield the middle, which may lie between two beams, then the beams' own angles outwards from it."""
        yield self.middle(grid)
        for step in sorted(range(self.beams), key=lambda beam: abs(2 * beam - (self.beams - 1))):
            yield (self.first + step) % grid.count * grid.increment

    def distance(self, angle: float, grid: Grid) -> float:
        """Return the angle (rad) between ``angle`` and the section's nearer edge."""
        edges = self.first * grid.increment, (self.first + self.beams - 1) * grid.increment
        return min(abs(math.remainder(edge - angle, 2.0 * math.pi)) for edge in edges)


def open_sections(safe: np.ndarray) -> list[Section]:
    """Return the runs of True in the circular ``safe`` (N,)."""
    if safe.all():
        return [Section(0, safe.size)]
    starts = np.flatnonzero(safe & ~np.roll(safe, 1))
    ends = np.flatnonzero(safe & ~np.roll(safe, -1))
    return [
        Section(int(first), int((ends[ends >= first].min(initial=ends[0] + safe.size) - first) + 1))
        for first in starts
    ]


def _is_safe(
    angle: float, beams: Beams, eligible: np.ndarray, grid: Grid, parameters: CepaParameters
) -> bool:
    if not eligible[grid.index(angle)]:
        return False
    corridor = float(parameters.body_radius), float(parameters.emergency_lookahead)
    return direction_is_safe(beams.ranges, grid.cos, grid.sin, math.cos(angle), math.sin(angle), *corridor)


def _choose(
    sections: list[Section],
    proposal: float | None,
    grid: Grid,
    parameters: CepaParameters,
    v_uav: Vector2,
    angle_0: float,
) -> Section:
    """Return the section whose edge is nearest to ``proposal``; without a proposal, the widest.

    Of sections that are about equal, the one along ``v_uav`` is returned.
    """

    def badness(section: Section) -> float:
        return -section.beams * grid.increment if proposal is None else section.distance(proposal, grid)

    def along_own_velocity(section: Section) -> float:
        angle = section.middle(grid) + angle_0
        return v_uav[0] * math.cos(angle) + v_uav[1] * math.sin(angle)

    limit = min(map(badness, sections)) + parameters.emergency_tie_angle
    tied = [section for section in sections if badness(section) <= limit]
    return max(tied, key=lambda section: (along_own_velocity(section), -badness(section)))
