"""A run loop with the real simulation and link, a client that answers scans, and a clock to wait by."""

from __future__ import annotations

import queue
import socket
import threading
import time
from pathlib import Path

from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.px4.mavlink.link import MavlinkLink
from simulation_tools.running.pacing import PacingParameters, WallClock
from simulation_tools.running.run_loop import RunLoop
from simulation_tools.simulation import Simulation, SimulationParameters

EMPTY = str(Path(__file__).resolve().parents[2] / "worlds" / "empty.world")
VELOCITY_ONLY = 0b0000_0101_1100_0111


class Recorder:
    """Takes what the loop publishes."""

    def __init__(self):
        self.outputs = []
        self.reports = []
        self.scans = queue.Queue()  # stamps in ms

    def publish(self, output):
        self.outputs.append(output)
        if output.scan is not None:
            self.scans.put(output.time_us // 1000)

    def report(self, figures, paused):
        self.reports.append((figures, paused))


class Client(threading.Thread):
    """An offboard client on its own socket: answers every scan with a setpoint of that scan's stamp."""

    def __init__(self, port, scans, delay_s=0.0, answers=lambda stamp_ms: [stamp_ms]):
        super().__init__(daemon=True)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", port))
        self._socket.settimeout(60.0)
        self._scans, self._delay_s, self._answers = scans, delay_s, answers
        self._mavlink = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
        self.stopped = threading.Event()

    def run(self):
        _, address = self._socket.recvfrom(2048)  # the flight controller speaks first
        while not self.stopped.is_set():
            try:
                stamp_ms = self._scans.get(timeout=0.05)
            except queue.Empty:
                continue
            time.sleep(self._delay_s)
            for answer_ms in self._answers(stamp_ms):
                message = mavlink.MAVLink_set_position_target_local_ned_message(
                    answer_ms, 1, 1, mavlink.MAV_FRAME_BODY_NED, VELOCITY_ONLY, *[0.0] * 11
                )
                self._socket.sendto(message.pack(self._mavlink), address)
        self._socket.close()


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class ExactClock:
    """A wall clock of a machine on which work takes no time: it goes on only while somebody waits."""

    def __init__(self):
        self.now_s = 0.0
        self.wall_clock = WallClock(now=lambda: self.now_s, sleep=self.sleep)

    def sleep(self, seconds):
        self.now_s += seconds


class UnhurriedLink(MavlinkLink):
    """The link of a loop whose clock is exact: waiting for input is waiting by that clock."""

    clock: ExactClock

    def wait(self, timeout_s):
        self.clock.sleep(timeout_s)
        return super().wait(0.0)


class Rig:
    """A simulation with its link and loop; `exact`: by a clock on which the machine has no influence."""

    def __init__(self, exact=False, **pacing):
        self.port = free_port()
        self.simulation = Simulation(SimulationParameters(world=EMPTY))
        link_type = UnhurriedLink if exact else MavlinkLink
        self.link = link_type(self.simulation.px4, self.port, 0, offboard_local_port=0)
        self.link.clock = ExactClock()
        self.clock = self.link.clock.wall_clock if exact else WallClock()
        self.recorder = Recorder()
        self.loop = RunLoop(
            self.simulation, self.link, self.recorder, PacingParameters(**pacing), clock=self.clock
        )
        self.warnings = []
        self.loop.on_warning = self.warnings.append
        self.client = None

    def answer(self, **how):
        self.client = Client(self.port, self.recorder.scans, **how)
        self.client.start()

    def run_until(self, simulated_s, wall_s=60.0):
        """Returns the wall time that it took."""
        began = self.clock.now()
        self.loop.run(
            lambda: self.simulation.time_us >= 1e6 * simulated_s or self.clock.now() - began > wall_s
        )
        return self.clock.now() - began

    def close(self):
        if self.client is not None:
            self.client.stopped.set()
            self.client.join(2.0)
        self.link.close()
        self.simulation.close()


def in_background(function):
    """Runs a function of another thread's; returns a function that gives its result."""
    results = queue.Queue()
    threading.Thread(target=lambda: results.put(function()), daemon=True).start()
    return lambda: results.get(timeout=200.0)
