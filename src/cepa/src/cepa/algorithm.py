"""What both algorithms share: the scan's normal form, the reference velocity in it, and the answers."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from cepa.decision import Decision, Reason, Vector2
from cepa.errors import VelocityError
from cepa.keep_out import KeepOut
from cepa.motion import Cloud, Motion, Ranging
from cepa.parameters import CepaParameters
from cepa.scan import Beams, Grid, LaserScan2D

REFERENCE_INCREMENT_RAD = math.radians(0.25)
"""Equation 6.3 is weighted by the increment over this one, so that one tuning of k3 serves every lidar."""


GREATEST_SPEED_M_S = 1e6
"""Nothing flies faster; beyond it the costs would overflow."""


@dataclass(frozen=True)
class Reference:
    """The reference velocity, relative to beam 0."""

    speed: float
    """m/s"""
    x: float
    """cosine of its direction"""
    y: float
    """sine of its direction"""
    beam: int
    """The beam nearest to its direction."""


class Algorithm(ABC):
    """Base class of every algorithm that steers by a scan."""

    wants_motion = False
    """Whether ``steer`` uses the motion; then it keeps something from scan to scan."""
    wants_cloud = False
    """Whether ``steer`` uses a cloud when there is one; making one takes time."""

    wants_single_beams = False
    """Whether ``steer`` tells which beams that stand out alone count, so that no filter should hide them."""

    def __init__(self, parameters: CepaParameters | None = None):
        self.parameters = parameters or CepaParameters()
        self.reset()

    def steer(
        self,
        scan: LaserScan2D,
        v_ref_xy: Sequence[float],
        v_uav_xy: Sequence[float] = (0.0, 0.0),
        motion: Motion | None = None,
        cloud: Cloud | None = None,
    ) -> Decision:
        """Return the velocity to fly; all velocities in m/s in the scan's frame.

        motion: what algorithms that remember need; without it they know the scan only. cloud: for those that
        climb. Algorithms of the thesis use neither.

        Raises:
            VelocityError: a velocity is not two finite numbers, or is faster than anything flies.
        """
        v_ref, v_uav = velocity(v_ref_xy, "v_ref"), velocity(v_uav_xy, "v_uav")
        return self._steer(scan, v_ref, v_uav, motion, cloud)

    @abstractmethod
    def _steer(
        self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2, motion: Motion | None, cloud: Cloud | None
    ) -> Decision:
        """Do what `steer` promises, with velocities that make sense."""

    def take_ranges(self, rangings: Sequence[Ranging]) -> None:
        """Take in what range finders measured when the next scan was taken; who cannot climb ignores it."""
        del rangings

    def take_keep_out(self, keep_out: KeepOut) -> None:
        """Keep out of these boxes from now on; who remembers nothing ignores them."""
        del keep_out

    def take_ready(self, is_ready: bool) -> None:
        """Take in whether the UAV flies what is answered; who tells nobody that it is held up ignores it."""
        del is_ready

    def on_next_scan(self, gap_s: float, turn_rad: float) -> None:
        """Take in how long ago the last scan was, and how far the lidar has turned about its z axis since.

        Who keeps the direction of its last answer needs this.
        """
        del gap_s, turn_rad

    def reset(self) -> None:
        """Forget what was kept of earlier scans."""
        self._grid = Grid(1, 2.0 * math.pi)  # until the first scan comes

    @property
    def commit_s(self) -> float:
        """How long an answer is safe to fly, s. Whoever flies it must brake if no other came until then."""
        return math.inf

    def beams(self, scan: LaserScan2D) -> Beams:
        """Return the scan's normal form, and keep the grid that belongs to it."""
        beams = normal_form(scan, self.parameters)
        if not self._grid.matches(beams):
            self._grid = Grid(beams.ranges.size, beams.increment)
        return beams

    def _eligible(self, beams: Beams) -> np.ndarray:
        return np.ones_like(beams.seen) if self.parameters.unseen_is_free else beams.seen

    def _reference(self, v_ref: Vector2, beams: Beams) -> Reference:
        speed = math.hypot(*v_ref)
        angle = math.atan2(v_ref[1], v_ref[0]) - beams.angle_0
        return Reference(speed, math.cos(angle), math.sin(angle), self._grid.index(angle))

    def _omega_weight(self) -> float:
        return self.parameters.k3 * self._grid.increment / REFERENCE_INCREMENT_RAD

    def _velocity(self, beam: int, speed: float, beams: Beams) -> Vector2:
        angle = beams.angle_0 + beam * self._grid.increment
        return speed * math.cos(angle), speed * math.sin(angle)


def normal_form(scan: LaserScan2D, parameters: CepaParameters) -> Beams:
    """Return the full turn of beams that the algorithms see.

    An obstacle that is too close for the lidar may touch the UAV. So it counts at ``body_radius`` at most. It
    is then an emergency, whatever the lidar's range_min is, and only directions away from it are open.
    """
    return scan.full_turn(parameters.dropout_beams, parameters.body_radius)


def velocity(value_xy: Sequence[float], name: str) -> Vector2:
    """Return ``value_xy`` as two floats; raises VelocityError unless it is two sensible numbers."""
    try:
        x, y = map(float, value_xy)
    except (TypeError, ValueError, OverflowError):
        raise VelocityError(f"{name} must be two numbers, not {value_xy!r}.") from None
    if not (math.isfinite(x) and math.isfinite(y)):
        raise VelocityError(f"{name} must be finite, not ({x}, {y}).")
    if math.hypot(x, y) > GREATEST_SPEED_M_S * (1.0 + 1e-9):  # a turn of the vector may have rounded it up
        raise VelocityError(f"{name} is beyond {GREATEST_SPEED_M_S:.0e} m/s: ({x}, {y}); check its source.")
    return x, y


def hover(reason: Reason, cost: float, directions_tested: int = 0) -> Decision:
    """Return the decision to stand still outside an emergency."""
    return Decision((0.0, 0.0), False, cost, directions_tested, reason)
