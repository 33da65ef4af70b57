"""The manoeuvres that were flown on real PX4, flown here, and the metrics of a step response.

The reference (`test/px4/data/px4_steps.csv.gz`) is PX4 SITL of July 2021 on the body `reference_quad`: every
step in the order of `MANOEUVRES`, the setpoints streamed at 50 Hz in OFFBOARD, the truth recorded at 25 Hz.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Iterator, Mapping, Protocol

import numpy as np

from simulation_tools.autopilot import VehicleState
from simulation_tools.geometry import Vector3
from simulation_tools.ned_frames import attitude_to_ned, enu_to_ned
from simulation_tools.px4.modes import Mode, Result
from simulation_tools.px4.setpoint import Setpoint

COLUMNS = ("t_s", "north_m", "east_m", "down_m", "v_north", "v_east", "v_down", "tilt_deg", "yaw_deg")
STREAM_PERIOD_US = 20_000
# The setpoint changes at t = 0 and is sent with the stream's next message, 10 ms later on average.
_FIRST_MESSAGE_US = 12_000
_BEFORE_S = 0.2  # recorded before the step


@dataclass(frozen=True)
class Manoeuvre:
    """A step of a quantity (a column, or `yaw_rate`, rad/s) from `first` to `last`, flown by one setpoint.

    before: a setpoint held for `before_s` until the step. nearer_than_m: then wait until the UAV, on its way
    home, is nearer than this in north. Three steps of the reference began like this; the integrator's
    content makes two points of overshoot. compared_s: how long the reference can be compared.
    """

    name: str
    quantity: str
    first: float
    last: float
    setpoint: Setpoint
    seconds: float
    before: Setpoint | None = None
    before_s: float = 0.0
    nearer_than_m: float = math.inf
    compared_s: float = math.inf


def _hold(north: float, down: float, yaw: float = 0.0) -> Setpoint:
    return Setpoint(position=(north, 0.0, down), yaw=yaw)


def _fly(north: float = 0.0, down: float = 0.0) -> Setpoint:
    return Setpoint(velocity=(north, 0.0, down), yaw=0.0)


def _velocity_pair(speed: float, nearer_than_m: float = math.inf) -> Iterator[Manoeuvre]:
    """A velocity step from the hover point at 3 m, and the step back to rest."""
    home, name = _hold(0.0, -3.0), f"{speed:.0f}"
    yield Manoeuvre(
        f"velocity_x_0_to_{name}", "v_north", 0.0, speed, _fly(speed), 11.5, home, 10.0, nearer_than_m
    )
    yield Manoeuvre(f"velocity_x_{name}_to_0", "v_north", speed, 0.0, _fly(0.0), 11.5)


MANOEUVRES = (
    *_velocity_pair(1.0),
    *_velocity_pair(2.0, nearer_than_m=0.0804),
    *_velocity_pair(4.0, nearer_than_m=0.0943),
    Manoeuvre("position_x_+5", "north_m", 0.0, 5.0, _hold(5.0, -2.0), 9.5, _hold(0.0, -2.0), 10.0, 0.092),
    Manoeuvre("position_x_-5", "north_m", 5.0, 0.0, _hold(0.0, -2.0), 9.5),
    Manoeuvre("position_x_+1", "north_m", 0.0, 1.0, _hold(1.0, -2.0), 9.5),
    Manoeuvre("position_down_-1", "down_m", -2.0, -3.0, _hold(0.0, -3.0), 6.5, _hold(0.0, -2.0), 12.0),
    Manoeuvre("position_down_+1", "down_m", -3.0, -2.0, _hold(0.0, -2.0), 6.5),
    Manoeuvre("yaw_+90_deg", "yaw_deg", 0.0, 90.0, _hold(0.0, -2.0, 0.5 * math.pi), 6.5),
    Manoeuvre("yaw_-90_deg", "yaw_deg", 90.0, 0.0, _hold(0.0, -2.0), 6.5),
    Manoeuvre(
        "yaw_rate_0_to_0.5", "yaw_rate", 0.0, 0.5, Setpoint(position=(0.0, 0.0, -2.0), yaw_rate=0.5), 4.0
    ),
    Manoeuvre("velocity_down_0_to_-1", "v_down", 0.0, -1.0, _fly(down=-1.0), 3.8, _hold(0.0, -2.0), 6.0),
    Manoeuvre(
        "velocity_down_0_to_1", "v_down", 0.0, 1.0, _fly(down=1.0), 3.0, _hold(0.0, -6.0), 8.0, compared_s=3.0
    ),
)
TAKEOFF = "takeoff_to_2m"


@dataclass(frozen=True)
class StepMetrics:
    """The metrics of a step response.

    rise_s: from 10 to 90 %. delay_s: until 50 %. settling_s: until it stays within 5 % of the step.
    peak_rate: the quantity's greatest change in a second.
    """

    rise_s: float
    delay_s: float
    overshoot_percent: float
    settling_s: float
    peak_tilt_deg: float
    peak_rate: float


class Commanded(Protocol):
    """A flight controller, as a pilot commands it."""

    @property
    def estimate_valid(self) -> bool:
        """Whether there is a local position."""
        ...

    def offer_setpoint(self, setpoint: Setpoint) -> bool:
        """Send an offboard setpoint."""
        ...

    def request_mode(self, mode: Mode) -> Result:
        """Ask for a mode."""
        ...

    def request_arm(self) -> Result:
        """Ask for arming."""
        ...


class Pilot:
    """Streams a setpoint at 50 Hz to a flight controller while `step` advances it, and records the truth.

    Positions, asked for and recorded, are in PX4's local frame.
    """

    def __init__(self, px4: Commanded, step: Callable[[], VehicleState]) -> None:
        """step: advance simulated time by one step and return the vehicle's true state then."""
        self._px4 = px4
        self._step = step
        self._setpoint: Setpoint | None = None
        self._due_us = 0
        self.state = step()
        self._origin_m = self.state.pose.position_m  # PX4's local frame begins where the vehicle stands

    def _place_ned_m(self) -> Vector3:
        return enu_to_ned(tuple(np.subtract(self.state.pose.position_m, self._origin_m)))

    def stream(self, setpoint: Setpoint, in_us: int = 0) -> None:
        """Send this setpoint from now on, for the first time in `in_us`."""
        self._setpoint = setpoint
        self._due_us = self.state.time_us + in_us

    def fly(self, seconds: float, until: Callable[[], bool] = lambda: False) -> np.ndarray:
        """Fly for a time, or until something is true; return the rows of COLUMNS, t from now."""
        start_us, rows = self.state.time_us, []
        while self.state.time_us - start_us < 1e6 * seconds and not until():
            if self._setpoint is not None and self.state.time_us >= self._due_us:
                self._px4.offer_setpoint(self._setpoint)
                self._due_us += STREAM_PERIOD_US
            self.state = self._step()
            rows.append((1e-6 * (self.state.time_us - start_us), *self._place_ned_m(), *_motion(self.state)))
        return np.array(rows).reshape(-1, len(COLUMNS))

    def take_off(self, rise_m: float, seconds: float) -> np.ndarray:
        """Arm in OFFBOARD and take off; return the rows from the arming on."""
        self.stream(_hold(0.0, self._place_ned_m()[2] - rise_m))
        self.fly(1.0)
        if not self._px4.estimate_valid:
            self.fly(20.0, until=lambda: self._px4.estimate_valid)
            self.fly(0.1)  # setpoints count from now on
        for answer in (self._px4.request_mode(Mode.OFFBOARD), self._px4.request_arm()):
            if answer is not Result.ACCEPTED:
                raise RuntimeError(f"the take-off was refused: {answer.name}")
        return self.fly(seconds)

    def manoeuvre(self, manoeuvre: Manoeuvre) -> np.ndarray:
        """Fly a step; return the rows of COLUMNS from 0.2 s before it, t = 0 at the step, yaw unwrapped."""
        if manoeuvre.before is not None:
            self.stream(manoeuvre.before)
            self.fly(manoeuvre.before_s)
            self.fly(30.0, until=lambda: self._place_ned_m()[0] < manoeuvre.nearer_than_m)
        before = self.fly(_BEFORE_S)
        before[:, 0] -= _BEFORE_S
        self.stream(manoeuvre.setpoint, _FIRST_MESSAGE_US)
        rows = np.vstack((before, self.fly(manoeuvre.seconds)))
        rows[:, -1] = np.degrees(np.unwrap(np.radians(rows[:, -1])))
        return rows


def _motion(state: VehicleState) -> tuple[float, ...]:
    """Return velocity (NED), tilt and yaw, degrees."""
    w, x, y, z = attitude_to_ned(state.pose.orientation_xyzw)
    tilt = math.acos(min(1.0, max(-1.0, 1.0 - 2.0 * (x * x + y * y))))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return (*enu_to_ned(state.velocity_world_m_s), math.degrees(tilt), math.degrees(yaw))


def read_reference(path: Path) -> dict[str, np.ndarray]:
    """Read the reference's series: rows of COLUMNS by the manoeuvre's name. The file may be gzipped."""
    series: dict[str, list] = defaultdict(list)
    for name, *values in np.genfromtxt(path, delimiter=",", skip_header=1, dtype=None, encoding="utf-8"):
        series[str(name)].append(values)
    return {name: np.array(rows, dtype=float) for name, rows in series.items()}


def quantity_of(manoeuvre: Manoeuvre, rows: np.ndarray) -> np.ndarray:
    """Return the values of the quantity that the manoeuvre steps, one for each row."""
    if manoeuvre.quantity == "yaw_rate":
        return np.gradient(np.radians(rows[:, COLUMNS.index("yaw_deg")]), rows[:, 0])
    return rows[:, COLUMNS.index(manoeuvre.quantity)]


def metrics(manoeuvre: Manoeuvre, rows: np.ndarray) -> StepMetrics:
    """Return the metrics of a step response from its rows."""
    kept = (rows[:, 0] >= 0.0) & (rows[:, 0] <= manoeuvre.compared_s)
    t, tilt = rows[kept, 0], rows[kept, COLUMNS.index("tilt_deg")]
    quantity = quantity_of(manoeuvre, rows)[kept]
    share = (quantity - manoeuvre.first) / (manoeuvre.last - manoeuvre.first)
    reached = {level: _first_at(t, share, level) for level in (0.1, 0.5, 0.9)}
    outside = np.flatnonzero(np.abs(share - 1.0) > 0.05)
    return StepMetrics(
        rise_s=reached[0.9] - reached[0.1],
        delay_s=reached[0.5],
        overshoot_percent=100.0 * (share.max() - 1.0),
        settling_s=t[outside[-1]] if len(outside) else 0.0,
        peak_tilt_deg=tilt.max(),
        peak_rate=np.abs(np.gradient(quantity, t)).max(),
    )


def _first_at(t: np.ndarray, share: np.ndarray, level: float) -> float:
    """Return the time at which the share first passes a level, interpolated; NaN: never."""
    above = np.flatnonzero(share > level)
    if not len(above):
        return math.nan
    after = max(int(above[0]), 1)
    return float(np.interp(level, share[after - 1 : after + 1], t[after - 1 : after + 1]))


def rms_percent(manoeuvre: Manoeuvre, rows: np.ndarray, reference: np.ndarray) -> float:
    """Return the RMS difference between two series of a manoeuvre, in per cent of the step."""
    t = reference[:, 0]
    kept = (t >= 0.0) & (t <= min(manoeuvre.compared_s, rows[-1, 0]))
    ours = np.interp(t[kept], rows[:, 0], quantity_of(manoeuvre, rows))
    difference = ours - quantity_of(manoeuvre, reference)[kept]
    return 100.0 * math.sqrt(np.mean(difference**2)) / abs(manoeuvre.last - manoeuvre.first)


def fly_all(pilot: Pilot) -> Mapping[str, np.ndarray]:
    """Take off to 3 m and fly every manoeuvre in the reference's order; return the rows by name."""
    pilot.take_off(3.0, 18.0)
    return {manoeuvre.name: pilot.manoeuvre(manoeuvre) for manoeuvre in MANOEUVRES}
