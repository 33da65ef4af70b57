"""Plays PX4's side of the simulator protocol, strictly: checks what a simulator sends, and flies with it.

    protocol_peer.py PORT SECONDS

Connects as PX4 does, answers every HIL_SENSOR with HIL_ACTUATOR_CONTROLS, climbs to 2 m and hovers there, 1 m
north of its start, by PD control on what the messages say (position and velocity from HIL_STATE_QUATERNION,
rates from the gyroscope). Prints one JSON object: what it counted, where it was at the end, and a sentence
for each violation of the protocol.

Imports nothing of the simulator: frames, units and constants here are written from PX4's documentation.
"""

from __future__ import annotations

import json
import math
import select
import socket
import sys
import time

from pymavlink.dialects.v20 import common

STEP_US = 4000
REST_US = 1_000_000  # how long it waits on the ground, and checks what a vehicle at rest measures
HEIGHT_M = 2.0
NORTH_M = 1.0
METRES_PER_DEGREE = math.pi / 180.0 * 6371000.0


class Peer:
    """One PX4: its connection, what it has seen so far, and its controller's state."""

    def __init__(self, port: int) -> None:
        self.violations: list[str] = []
        self.socket = _connect(port)
        self.mav = common.MAVLink(None, srcSystem=1, srcComponent=1)
        self.counts = {"HIL_SENSOR": 0, "HIL_GPS": 0, "HIL_STATE_QUATERNION": 0}
        self.time_us = self.start_us = 0
        self.fixes: list[tuple[int, int]] = []  # time, altitude in mm
        self.truths: list[tuple[int, int]] = []
        self.readings: list[tuple] = []
        self.home = None
        self.truth = None
        self.thrust_offset = 0.0

    def say(self, message) -> None:
        self.socket.sendall(bytes(message.pack(self.mav)))
        self.mav.seq = (self.mav.seq + 1) % 256

    def violated(self, sentence: str) -> None:
        if len(self.violations) < 20:
            self.violations.append(f"t = {1e-6 * self.time_us:.3f} s: {sentence}")

    def expect(self, what: str, value: float, wanted: float, tolerance: float) -> None:
        if not abs(value - wanted) <= tolerance:
            self.violated(f"{what} is {value:g}, not {wanted:g} within {tolerance:g}")

    def run(self, seconds: float) -> None:
        self.say(common.MAVLink_heartbeat_message(0, 12, 0, 0, 0, 3))
        self.say(common.MAVLink_command_long_message(0, 0, 511, 0, 115, 5000, 0, 0, 0, 0, 0))
        while not self.start_us or self.time_us - self.start_us < 1e6 * seconds:
            sensor = None
            for message in self.hear():
                sensor = self.take(message) or sensor
            if sensor is not None:
                self.answer(sensor)

    def hear(self) -> list:
        data = self.socket.recv(65536)
        if not data:
            raise SystemExit("the simulator closed the connection")
        return self.mav.parse_buffer(data) or []

    def take(self, message):
        """Check one message; returns it when it wants an answer."""
        kind = message.get_type()
        if kind not in self.counts:
            self.violated(f"{kind} is not a message of the protocol")
            return None
        self.counts[kind] += 1
        if kind == "HIL_SENSOR":
            self.check_sensor(message)
            return message
        if kind == "HIL_GPS":
            self.fixes.append((message.time_usec, message.alt))
            if message.fix_type < 3 or not 0 < message.eph < 300 or message.satellites_visible < 6:
                self.violated("a GPS fix that the estimator would refuse")
        else:
            self.truth = message
            self.truths.append((message.time_usec, message.alt))
            self.home = self.home or (message.lat, message.lon, message.alt)
        return None

    def check_sensor(self, m) -> None:
        if self.time_us and m.time_usec - self.time_us != STEP_US:
            self.violated(f"time went on by {m.time_usec - self.time_us} us")
        self.time_us = m.time_usec
        self.start_us = self.start_us or m.time_usec
        if m.fields_updated != 7167:
            self.violated(f"fields_updated is {m.fields_updated}")
        standard_hpa = 1013.25 * (1.0 - 2.25577e-5 * m.pressure_alt) ** 5.25588
        self.expect("abs_pressure in hPa, for pressure_alt,", m.abs_pressure, standard_hpa, 0.05)
        self.expect("temperature in degC", m.temperature, 15.0 - 0.0065 * m.pressure_alt, 0.1)
        strength = math.sqrt(m.xmag**2 + m.ymag**2 + m.zmag**2)
        self.expect("the magnetic field in Gauss", strength, 0.4786, 0.02)
        self.readings.append(
            (m.xacc, m.yacc, m.zacc, m.xgyro, m.ygyro, m.zgyro, m.xmag, m.ymag, m.zmag, m.abs_pressure)
        )
        if len(self.readings) > 100:
            self.readings.pop(0)
            if any(len(set(values)) == 1 for values in zip(*self.readings)):
                self.violated("a sensor said the same for 100 samples")
        if STEP_US * 10 < m.time_usec - self.start_us < REST_US:
            self.check_rest(m)

    def check_rest(self, m) -> None:
        for name, value, wanted in (("xacc", m.xacc, 0.0), ("yacc", m.yacc, 0.0), ("zacc", m.zacc, -9.81)):
            self.expect(name + " at rest in m/s2", value, wanted, 0.2)
        for name in ("xgyro", "ygyro", "zgyro"):
            self.expect(name + " at rest in rad/s", getattr(m, name), 0.0, 0.05)
        if self.truth is not None:
            self.expect("the heading by the compass", _difference(_compass(m), _yaw(self.truth)), 0.0, 0.05)

    def answer(self, sensor) -> None:
        """Answer a measurement; first see that the simulator really waits for the answer."""
        if self.counts["HIL_SENSOR"] % 100 == 0 and select.select([self.socket], [], [], 0.02)[0]:
            self.violated("the simulator went on without waiting for the answer")
        flies = self.truth is not None and self.time_us - self.start_us > REST_US
        controls = self.control(sensor) if flies else [0.0] * 4
        mode = 1 | (128 if flies else 0)
        self.say(common.MAVLink_hil_actuator_controls_message(self.time_us, controls + [0.0] * 12, mode, 1))

    def control(self, sensor) -> list[float]:
        """Return controls of a quadrotor X: front right, rear left, front left, rear right."""
        t = self.truth
        north, east, height = self.place()
        self.thrust_offset += 0.002 * (min(HEIGHT_M - height, 0.5) - 0.01 * -t.vz)
        thrust = 0.5 + self.thrust_offset + 0.25 * min(HEIGHT_M - height, 1.0) + 0.25 * 0.01 * t.vz
        pull_n, pull_e = 0.08 * (NORTH_M - north) - 0.0012 * t.vx, -0.08 * east - 0.0012 * t.vy
        roll, pitch, yaw = _euler(t.attitude_quaternion)
        ahead = math.cos(yaw) * pull_n + math.sin(yaw) * pull_e
        right = -math.sin(yaw) * pull_n + math.cos(yaw) * pull_e
        x = 0.4 * (_limit(right, 0.2) - roll) - 0.08 * sensor.xgyro
        y = 0.4 * (_limit(-ahead, 0.2) - pitch) - 0.08 * sensor.ygyro
        z = -0.2 * sensor.zgyro
        mixed = (thrust - x + y + z, thrust + x - y + z, thrust + x + y - z, thrust - x - y - z)
        return [_limit(value - 0.5, 0.5) + 0.5 for value in mixed]

    def place(self) -> tuple[float, float, float]:
        """Return how far north, east and above its start it is, m."""
        latitude_scale = math.cos(math.radians(1e-7 * self.home[0]))
        north = METRES_PER_DEGREE * 1e-7 * (self.truth.lat - self.home[0])
        east = METRES_PER_DEGREE * latitude_scale * 1e-7 * (self.truth.lon - self.home[1])
        return north, east, 1e-3 * (self.truth.alt - self.home[2])

    def report(self) -> dict:
        later_fixes = self.fixes[1:]  # the first comes with the connection, at any phase
        gaps_us = [after[0] - before[0] for before, after in zip(later_fixes, later_fixes[1:])]
        return {
            "violations": self.violations,
            "counts": self.counts,
            "ended_us": self.time_us,
            "seconds": 1e-6 * (self.time_us - self.start_us),
            "gps_gaps_us": [min(gaps_us), max(gaps_us)] if gaps_us else [],
            "gps_late_s": self.gps_delay_s(),
            "place_m": self.place(),
            "speed_cm_s": math.sqrt(self.truth.vx**2 + self.truth.vy**2 + self.truth.vz**2),
        }

    def gps_delay_s(self) -> float:
        """Return how late the GPS is: the delay at which its altitudes agree best with the true ones."""
        truth = dict(self.truths)

        def misfit(delay_us):
            pairs = [(alt, truth.get(t - delay_us)) for t, alt in self.fixes]
            errors = [(alt - true) ** 2 for alt, true in pairs if true is not None]
            return sum(errors) / len(errors) if len(errors) > 20 else math.inf

        return 1e-6 * min(range(0, 300_000, STEP_US), key=misfit)


def _connect(port: int) -> socket.socket:
    """Connect, and try again until somebody listens, as PX4 does."""
    while True:
        try:
            peer = socket.create_connection(("127.0.0.1", port), timeout=200.0)
        except ConnectionRefusedError:
            time.sleep(0.05)
            continue
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return peer


def _limit(value: float, most: float) -> float:
    return max(-most, min(most, value))


def _euler(q) -> tuple[float, float, float]:
    w, x, y, z = q
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(_limit(2 * (w * y - z * x), 1.0))
    return roll, pitch, math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _yaw(truth) -> float:
    return _euler(truth.attitude_quaternion)[2]


def _compass(m) -> float:
    """Return the heading, rad from north, of a level vehicle; Zurich's declination is 2 degrees east."""
    return math.atan2(-m.ymag, m.xmag) + math.atan2(0.00771, 0.21523)


def _difference(a: float, b: float) -> float:
    return math.remainder(a - b, 2.0 * math.pi)


if __name__ == "__main__":
    px4 = Peer(int(sys.argv[1]))
    px4.run(float(sys.argv[2]))
    print(json.dumps(px4.report()))
