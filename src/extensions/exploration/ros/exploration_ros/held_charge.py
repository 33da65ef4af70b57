"""Asks the flight controller at which charge its simulated battery stays."""

from __future__ import annotations

import threading
import time
from typing import Any, Callable

import rospy
from mavros_msgs.srv import ParamGet

from exploration.energy import EnergyWatch
from flight_basics.errors import ParameterError
from node_tools.services import ServiceCall

TRIES = 10
AGAIN_S = 1.0
"""Wall time between two tries; MAVROS reads all parameters first, which takes some seconds."""


class HeldCharge:
    """Tells the watch over the energy where a simulated battery stops sinking.

    Calls: mavros/param/get (mavros_msgs/ParamGet). Parameter: ~held_by (str, empty): the flight controller's
    parameter that says it in percent, SIM_BAT_MIN_PCT of PX4 SITL. Empty: a real battery, which sinks on.
    """

    def __init__(self, energy: EnergyWatch, call: Callable[..., Any] | None = None) -> None:
        self._energy, self._name = energy, str(rospy.get_param("~held_by", "")).strip()
        self._call = call or ServiceCall("mavros/param/get", ParamGet)

    def ask(self) -> None:
        """Ask in a thread of its own. Call it when a flight begins."""
        if self._name:
            threading.Thread(target=self.ask_now, daemon=True).start()

    def ask_now(self, again_s: float = AGAIN_S) -> None:
        """Ask until the flight controller answers."""
        for _ in range(TRIES):
            try:
                answer = self._call(self._name)
                if answer.success:
                    self._energy.hold_at(0.01 * (answer.value.real or answer.value.integer))
                    return
            except (rospy.ServiceException, ParameterError) as error:
                why = str(error)
            else:
                why = f"it has no {self._name}"
            time.sleep(again_s)
        rospy.logwarn(
            "The flight controller does not say where its simulated battery stays (%s). A charge that stays "
            "there counts as frozen.",
            why,
        )
