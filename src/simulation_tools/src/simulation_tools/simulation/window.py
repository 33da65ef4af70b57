"""PyBullet's own window: it follows the UAV, and is drawn only as often as the machine can."""

from __future__ import annotations

import math
import time
from typing import Callable

from simulation_tools.geometry import Vector3
from simulation_tools.sdf.elements import World
from simulation_tools.world.engine import WorldError, pybullet
from simulation_tools.world.kinematics import BodyState
from simulation_tools.world.world import PhysicsWorld

AWAY_M, ASIDE_DEG, DOWN_DEG = 3.0, -90.0, -25.0
"""The camera stands behind a UAV that looks along x, and looks down on it. The mouse turns it."""
MOVED_M = 0.3
"""A UAV that has flown so far takes the camera with it."""
PERIOD_S, LONGEST_S = 0.1, 2.0
"""Between two pictures at least and at most, wall time."""
SHARE = 0.2
"""Of the wall time for pictures at most. Without a graphics card, one takes as long as hundreds of steps."""
PANELS = (
    pybullet.COV_ENABLE_GUI,
    pybullet.COV_ENABLE_RGB_BUFFER_PREVIEW,
    pybullet.COV_ENABLE_DEPTH_BUFFER_PREVIEW,
    pybullet.COV_ENABLE_SEGMENTATION_MARK_PREVIEW,
)


class Window:
    """Shows a world, by a copy of it: in a world with a window, each call waits for a picture.

    Args:
        shown: the world. follows: name of the model in the middle. has_window: False for tests without a
            display. clock: wall time, s.
    """

    def __init__(
        self,
        shown: PhysicsWorld,
        follows: str,
        has_window: bool = True,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._shown, self._follows, self._clock = shown, follows, clock
        self.copy = PhysicsWorld(World("window", ()), gui=has_window, drawn=not has_window)
        self._next_s, self._camera = -math.inf, (ASIDE_DEG, DOWN_DEG, AWAY_M)
        self._middle_m: Vector3 | None = None
        for panel in PANELS:
            pybullet.configureDebugVisualizer(panel, 0, physicsClientId=self.copy.client)
        self.update()

    def update(self) -> bool:
        """Draw a picture if one is due. Return whether one was drawn."""
        began_s = self._clock()
        if began_s < self._next_s:
            return False
        self._draw(False)
        self._copy_models()
        self._follow()
        self._draw(True)
        self._next_s = began_s + min(max(PERIOD_S, (self._clock() - began_s) / SHARE), LONGEST_S)
        return True

    def close(self) -> None:
        """Close the window."""
        self.copy.close()

    def _copy_models(self) -> None:
        names = set(self._shown.model_names())
        for name in set(self.copy.model_names()) - names:
            self.copy.delete(name)
        for name in sorted(names):
            state = self._shown.get_state(name)
            if name not in self.copy.model_names():
                self._spawn(name, state)
            elif state.pose != self.copy.get_state(name).pose:
                self.copy.set_state(name, BodyState(state.pose))

    def _spawn(self, name: str, state: BodyState) -> None:
        model = self._shown.model(name)
        rigid = frozenset(joint.name for joint in model.joints)
        try:
            self.copy.spawn(model, name, state.pose, rigid)
        except WorldError:  # rigid, it may be what PyBullet cannot build
            self.copy.spawn(model, name, state.pose)

    def _follow(self) -> None:
        """Move the camera with the UAV, but leave it as the mouse has turned it."""
        if self._follows not in self._shown.model_names():
            return
        place_m = self._shown.get_state(self._follows).pose.position_m
        if self._middle_m is not None:
            if math.dist(place_m, self._middle_m) < MOVED_M:
                return
            told = pybullet.getDebugVisualizerCamera(physicsClientId=self.copy.client)
            if told[10] > 0.0:  # else PyBullet does not know it
                self._camera = told[8], told[9], told[10]
        yaw_deg, pitch_deg, away_m = self._camera
        self._middle_m = place_m
        pybullet.resetDebugVisualizerCamera(
            away_m, yaw_deg, pitch_deg, place_m, physicsClientId=self.copy.client
        )

    def _draw(self, is_on: bool) -> None:
        pybullet.configureDebugVisualizer(
            pybullet.COV_ENABLE_RENDERING, int(is_on), physicsClientId=self.copy.client
        )
