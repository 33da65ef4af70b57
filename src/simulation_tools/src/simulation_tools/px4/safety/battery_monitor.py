"""Where PX4 has its battery's state from: a monitor, or a simulated battery of its own."""

from __future__ import annotations

from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.vehicle.energy.battery import BatteryReading

_CELLS, _CELL_FULL_V, _CELL_EMPTY_V = 4, 4.05, 3.7
_CURRENT_A = -1.0  # as PX4's simulated battery says


class BatteryMonitor:
    """Knows the newest reading.

    Without a monitor it is PX4's simulated battery. That one drains evenly while the vehicle is armed, in
    SIM_BAT_DRAIN seconds, down to SIM_BAT_MIN_PCT.
    """

    def __init__(self, parameters: Px4Parameters) -> None:
        self._parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Be full until told otherwise."""
        self._simulated = 1.0
        self._measured: BatteryReading | None = None

    def swap(self) -> None:
        """Let the simulated battery be full again."""
        self._simulated = 1.0

    @property
    def remaining(self) -> float:
        """The charge, 0..1."""
        return self._simulated if self._measured is None else self._measured.remaining

    @property
    def reading(self) -> BatteryReading:
        """The newest reading."""
        return _simulated(self._simulated) if self._measured is None else self._measured

    def update(self, measured: BatteryReading | None, armed: bool, dt_s: float) -> None:
        """Take in what a monitor tells; None: simulate dt_s."""
        self._measured = measured
        if measured is None:
            p = self._parameters
            drained = dt_s / p["SIM_BAT_DRAIN"] if armed else 0.0
            self._simulated = max(self._simulated - drained, 0.01 * p["SIM_BAT_MIN_PCT"])


def _simulated(remaining: float) -> BatteryReading:
    voltage = _CELLS * (_CELL_EMPTY_V + (_CELL_FULL_V - _CELL_EMPTY_V) * remaining)
    return BatteryReading(voltage, _CURRENT_A, 0.0, remaining, _CELLS)
