"""Buttons of a joystick that give an order when they are pressed, not while they are held."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Sequence

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ParameterError


class Order(enum.Enum):
    """What a pilot may order at any time. The value is the name of its service."""

    PAUSE = "pause"
    RESUME = "resume"
    HOME = "home"
    LAND = "land"


@dataclass(frozen=True)
class ButtonParameters:
    """Numbers of the joystick's buttons, as in sensor_msgs/Joy. -1: no button gives this order.

    Raises:
        ParameterError: a number out of range, or one button for two orders.
    """

    button_pause: int = limited(0, -1, 31)
    button_resume: int = limited(3, -1, 31)
    button_home: int = limited(1, -1, 31)
    button_land: int = limited(2, -1, 31)

    def __post_init__(self) -> None:
        check_parameters(self)
        used = [button for button in vars(self).values() if button >= 0]
        if len(set(used)) < len(used):
            raise ParameterError("Each order needs a button of its own.")


class PilotButtons:
    """Knows which buttons are held."""

    def __init__(self, parameters: ButtonParameters | None = None) -> None:
        p = parameters or ButtonParameters()
        self._orders = {
            p.button_land: Order.LAND,
            p.button_home: Order.HOME,
            p.button_pause: Order.PAUSE,
            p.button_resume: Order.RESUME,
        }
        self._held: frozenset[int] | None = None

    def press(self, buttons: Sequence[int]) -> Order | None:
        """Take the state of all buttons. Return the order that begins now; landing comes before the others.

        What is held when the joystick is heard first gives no order.
        """
        held = frozenset(number for number, value in enumerate(buttons) if value)
        before, self._held = self._held, held
        if before is None:
            return None
        return next((order for number, order in self._orders.items() if number in held - before), None)
