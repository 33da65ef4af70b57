"""Lets a closed loop land at home for a full battery and take off again, as the node of an errand does."""

from __future__ import annotations

from typing import Callable

from master_thesis.exploring.stopover import Stopover
from master_thesis.flight.closed_loop import ClosedLoop
from simulation_tools.simulation import SimulationError


class BatterySwap:
    """Follows a UAV that hovers at home: it lands, gets a full battery, and hovers again.

    Args:
        loop: the flight. take_battery: called right after the landing, says whether there is a full one.
    """

    def __init__(self, loop: ClosedLoop, take_battery: Callable[[], bool]) -> None:
        self._loop, self._take_battery, self._stopover = loop, take_battery, Stopover()
        self._must_swap = False

    @property
    def is_under_way(self) -> bool:
        """Whether it lands, stands or takes off."""
        return self._stopover.is_under_way

    def begin(self) -> None:
        """Order to land."""
        self._stopover.begin()
        self._loop.monitor.course.lands_between = True
        self._loop.land()

    def follow(self) -> bool:
        """Do what is due; call it at each step. Return whether the UAV hovers again, once."""
        loop = self._loop
        if self._stopover.on_armed(loop.is_armed):
            self._must_swap = self._take_battery()
            if not self._must_swap:
                loop.monitor.abort("There is no full battery.")
        if self._must_swap:
            try:
                loop.simulation.swap_battery()
            except SimulationError:
                return False  # the rotors still turn
            self._must_swap = False
            loop.publisher.restart()
            self._stopover.take_off()
        if not self._stopover.on_ready(loop.publisher.ready):
            return False
        loop.monitor.course.lands_between = False
        return True
