"""The yaw regulator with the stamps of its messages: one class for the node and for flights without ROS."""

from __future__ import annotations

from typing import Any, NamedTuple

from inspection_tools.yaw.regulator import NO_VELOCITY, YawRegulator, YawRegulatorParameters
from stamp_pairing.pairing import Paired, StampPairing

Vector2 = tuple[float, float]


class Turn(NamedTuple):
    """A command that is complete."""

    command: Any
    """As it was given."""
    yaw_rate_rad_s: float


class YawSteering:
    """Adds a yaw rate to each command, in their order. Stamps are whole nanoseconds of one clock.

    A command waits for the reference of its own stamp (see `StampPairing`). A reference that is more than
    `reference_max_age` from its command counts as none.
    """

    def __init__(self, parameters: YawRegulatorParameters | None = None) -> None:
        self._regulator = YawRegulator(parameters)
        self._pairing = StampPairing(("reference",), trusting=False)
        self._front: tuple[int, Vector2] | None = None
        self._last: tuple[int, float] | None = None
        """Stamp and yaw rate of the last command."""

    @property
    def parameters(self) -> YawRegulatorParameters:
        """The regulator's parameters."""
        return self._regulator.parameters

    @parameters.setter
    def parameters(self, parameters: YawRegulatorParameters) -> None:
        self._regulator.parameters = parameters

    def restart(self) -> None:
        """Forget everything, as after a clock that jumped back."""
        self._regulator.reset()
        self._pairing.clear()
        self._front = self._last = None

    def on_front(self, stamp_ns: int, front: Vector2) -> None:
        """Take in where the front is to point (x, y), levelled body frame; it counts as long as a reference.

        Meanwhile the UAV turns there, wherever it flies. Zeros end it at once.
        """
        self._front = (stamp_ns, front) if any(front) else None

    def on_reference(self, stamp_ns: int, reference_m_s: Vector2) -> list[Turn]:
        """Take in the wanted velocity (x, y), levelled body frame."""
        return self._turns(self._pairing.offer("reference", stamp_ns, reference_m_s))

    def on_command(self, stamp_ns: int, velocity_m_s: Vector2, command: Any = None) -> list[Turn]:
        """Take in the velocity (x, y) to be flown, levelled body frame. command: comes back with it."""
        return self._turns(self._pairing.lead(stamp_ns, (velocity_m_s, command)))

    def _turns(self, ready: list[Paired]) -> list[Turn]:
        turns: list[Turn] = []
        if not ready:
            return turns
        max_age_ns = round(1e9 * self.parameters.reference_max_age)
        for paired in ready:
            velocity_m_s, command = paired.leader.value
            wanted = paired.fresh("reference", max_age_ns, NO_VELOCITY)
            if self._front is not None and abs(paired.leader.stamp_ns - self._front[0]) <= max_age_ns:
                wanted_rad_s = self._regulator.turn_to(self._front[1])
            else:
                wanted_rad_s = self._regulator.update(velocity_m_s, wanted)
            turns.append(Turn(command, self._eased(paired.leader.stamp_ns, wanted_rad_s)))
        return turns

    def _eased(self, stamp_ns: int, wanted_rad_s: float) -> float:
        """Return the yaw rate that `max_yaw_acceleration` allows after the last command's."""
        rate_rad_s, most_rad_s2 = wanted_rad_s, self.parameters.max_yaw_acceleration
        if self._last is not None and most_rad_s2 > 0.0:
            before_ns, before_rad_s = self._last
            change_rad_s = most_rad_s2 * 1e-9 * max(stamp_ns - before_ns, 0)
            rate_rad_s = min(max(wanted_rad_s, before_rad_s - change_rad_s), before_rad_s + change_rad_s)
        self._last = stamp_ns, rate_rad_s
        return rate_rad_s
