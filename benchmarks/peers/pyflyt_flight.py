"""PyFlyt's quadrotor holds a position. It runs on PyFlyt's own Python: see `flights.fly`."""

from __future__ import annotations

import sys

import numpy as np
from PyFlyt.core import Aviary

from benchmarks.peers.report import write
from benchmarks.shared.speed import timed

POSITION_MODE = 7  # x, y, heading, z
WARM_UP = 50  # steps, in which numba compiles


def main(simulated_s: float, report: str) -> None:
    """Fly as PyFlyt's quick start does: one QuadX, physics at 240 Hz, control at 120 Hz, no rendering."""
    world = Aviary(
        start_pos=np.array([[0.0, 0.0, 1.0]]),
        start_orn=np.zeros((1, 3)),
        render=False,
        drone_type="quadx",
        seed=1,
    )
    world.set_mode(POSITION_MODE)
    goal_m = np.array([1.0, 0.0, 1.0])
    world.set_setpoint(0, np.array([goal_m[0], goal_m[1], 0.0, goal_m[2]]))
    for _ in range(WARM_UP):
        world.step()

    def fly() -> float:
        before = world.physics_steps
        for _ in range(round(simulated_s / world.step_period)):
            world.step()
        return (world.physics_steps - before) / world.physics_hz

    speed = timed(fly)
    write(report, speed, float(np.linalg.norm(world.state(0)[-1] - goal_m)))


if __name__ == "__main__":
    main(float(sys.argv[1]), sys.argv[2])
