"""The yaw regulator with the stamps of its messages: one class for the node and for flights without ROS."""

from __future__ import annotations

from typing import Any, NamedTuple, Tuple

from inspection_tools.yaw.pairing import Pair, ReferencePairing
from inspection_tools.yaw.regulator import NO_VELOCITY, YawRegulator, YawRegulatorParameters

Vector2 = Tuple[float, float]


class Turn(NamedTuple):
    """A command that is complete."""

    command: Any
    """As it was given."""
    yaw_rate_rad_s: float


class YawSteering:
    """Adds a yaw rate to each command, in their order. Stamps are whole nanoseconds of one clock.

    A command waits for the reference of its own stamp (see `ReferencePairing`). A reference that is more than
    `reference_max_age` from its command counts as none.
    """

    def __init__(self, parameters: YawRegulatorParameters | None = None) -> None:
        self._regulator = YawRegulator(parameters)
        self._pairing = ReferencePairing()

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

    def on_reference(self, stamp_ns: int, reference_m_s: Vector2) -> list[Turn]:
        """Take in the wanted velocity (x, y), levelled body frame."""
        return self._turns(self._pairing.offer_reference(stamp_ns, reference_m_s))

    def on_command(self, stamp_ns: int, velocity_m_s: Vector2, command: Any = None) -> list[Turn]:
        """Take in the velocity (x, y) to be flown, levelled body frame. command: comes back with it."""
        return self._turns(self._pairing.offer_command(stamp_ns, (stamp_ns, velocity_m_s, command)))

    def _turns(self, pairs: list[Pair]) -> list[Turn]:
        turns = []
        for (stamp_ns, velocity_m_s, command), reference in pairs:
            is_fresh = reference and abs(stamp_ns - reference[0]) <= 1e9 * self.parameters.reference_max_age
            wanted = reference[1] if reference and is_fresh else NO_VELOCITY
            turns.append(Turn(command, self._regulator.update(velocity_m_s, wanted)))
        return turns
