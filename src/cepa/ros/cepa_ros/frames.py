"""Takes velocities and lidar poses of other frames to the body frame, by TF."""

from __future__ import annotations

import math
from typing import NamedTuple

from node_tools.conversions import yaw_of_xyzw
from node_tools.newest_transforms import FrameError, NewestTransforms

LEVEL_COSINE = math.cos(math.radians(20.0))
"""A lidar whose axis leans more than this does not scan the plane in which CEPA steers."""


class PlaneTurn:
    """Takes plane vectors of one frame to another: a turn, and a mirror for a lidar upside down."""

    def __init__(self, yaw_rad: float, flipped: bool = False):
        self._yaw_rad, self.flipped = yaw_rad, flipped
        self._cos, self._sin = math.cos(yaw_rad), math.sin(yaw_rad)
        self._side = -1.0 if flipped else 1.0

    def upright(self) -> PlaneTurn:
        """Return the turn of a frame with the same x axis that is not upside down."""
        return PlaneTurn(self._yaw_rad)

    def apply(self, x: float, y: float) -> tuple[float, float]:
        """Take a vector of the source frame to the target frame."""
        y *= self._side
        return self._cos * x - self._sin * y, self._sin * x + self._cos * y

    def undo(self, x: float, y: float) -> tuple[float, float]:
        """Take a vector of the target frame to the source frame."""
        return self._cos * x + self._sin * y, self._side * (self._cos * y - self._sin * x)


class Mount(NamedTuple):
    """How a lidar sits on the body: its turn of the plane, and its whole pose in the base frame."""

    turn: PlaneTurn
    position_m: tuple[float, float, float]
    orientation_xyzw: tuple[float, float, float, float]

    def upright(self) -> Mount:
        """Return the mounting of this lidar after half a turn around its x axis."""
        x, y, z, w = self.orientation_xyzw
        return Mount(self.turn.upright(), self.position_m, (w, z, -y, -x))


class Frames:
    """Turns of the horizontal plane between frames, by the newest transforms."""

    def __init__(self, base_frame: str) -> None:
        self._base_frame = base_frame.lstrip("/")
        self._mounts: dict[str, Mount] = {}
        self._transforms = NewestTransforms()

    def restart(self) -> None:
        """Forget moving transforms, as after a clock that jumped back. Mountings of lidars stay known."""
        self._transforms.restart()

    def lidar_mount(self, frame: str) -> Mount:
        """Return how the lidar sits on the base frame. TF is asked once for each frame.

        Raises:
            FrameError: TF does not know it yet, or the lidar does not lie flat.
        """
        if frame not in self._mounts:
            mount = self._look_up(frame)
            x, y, _, _ = mount.orientation_xyzw
            lean_cosine = 1.0 - 2.0 * (x * x + y * y)
            if abs(lean_cosine) < LEVEL_COSINE:
                lean = math.degrees(math.acos(lean_cosine))
                raise FrameError(
                    f'The lidar "{frame}" leans by {lean:.0f} degrees; CEPA needs one that lies flat.'
                )
            self._mounts[frame] = mount
        return self._mounts[frame]

    def mount(self, frame: str) -> Mount:
        """Return how a sensor sits on the base frame, in whatever attitude.

        Raises:
            FrameError: TF does not know it (yet).
        """
        return self._look_up(frame)

    def yaw_turn(self, frame: str) -> PlaneTurn:
        """Return how a levelled velocity of ``frame`` turns into the base frame, by its newest yaw.

        Raises:
            FrameError: TF does not know it (yet).
        """
        return self._look_up(frame).turn

    def _look_up(self, frame: str) -> Mount:
        found = self._transforms.look_up(self._base_frame, frame or self._base_frame)
        x, y, _, _ = found.rotation_xyzw
        turn = PlaneTurn(yaw_of_xyzw(found.rotation_xyzw), flipped=x * x + y * y > 0.5)
        return Mount(turn, found.translation_m, found.rotation_xyzw)
