"""crazyflow's quadrotor holds a position. It runs on crazyflow's own Python: see `flights.fly`."""

from __future__ import annotations

import sys

import numpy as np
from crazyflow.control import Control
from crazyflow.sim import Sim

from benchmarks.peers.report import write
from benchmarks.shared.speed import timed

WARM_UP = 3  # steps, in which JAX compiles
FREQUENCY_HZ = 500


def main(simulated_s: float, report: str) -> None:
    """Fly as crazyflow's quick start does: one world, one drone, dynamics at 500 Hz, a setpoint at 100 Hz."""
    simulation = Sim(n_worlds=1, n_drones=1, freq=FREQUENCY_HZ, control=Control.state)
    simulation.reset()
    goal_m = np.array([0.0, 0.0, 0.5])
    command = np.zeros((1, 1, 16), dtype=np.float32)
    command[0, 0, :3] = goal_m
    command[0, 0, 9:13] = (0.0, 0.0, 0.0, 1.0)  # a quaternion of zeros makes the state NaN
    steps = simulation.freq // simulation.control_freq

    def fly(setpoints: int) -> float:
        for _ in range(setpoints):
            simulation.state_control(command)
            simulation.step(steps)
        simulation.data.states.pos.block_until_ready()  # JAX computes in the background
        return setpoints * steps / simulation.freq

    fly(WARM_UP)
    speed = timed(lambda: fly(round(simulated_s * simulation.control_freq)))
    place_m = np.asarray(simulation.data.states.pos)[0, 0]
    write(report, speed, float(np.linalg.norm(place_m - goal_m)))


if __name__ == "__main__":
    main(float(sys.argv[1]), sys.argv[2])
