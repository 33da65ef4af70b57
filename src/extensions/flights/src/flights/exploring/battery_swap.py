"""Lets a closed loop land at home for a full battery and take off again, as the node of a led flight does."""

from __future__ import annotations

from typing import Callable

import numpy as np

from flights.errors import FlightError
from flights.exploring.stopover import Stopover
from flights.exploring.volume_of_flight import VolumeOfFlight
from flights.flight.closed_loop import ClosedLoop
from flights.flight.take_off import hover_height_m
from simulation_tools.simulation import SimulationError


class BatterySwap:
    """Follows a UAV that hovers at home: it lands, gets a full battery, and hovers again.

    Args:
        loop: the flight. take_battery: called right after the landing, says whether there is a full one.
        volume: the map, which knows what is above the UAV.

    If there is no battery, or too little room above, the run ends with a sentence.
    """

    def __init__(self, loop: ClosedLoop, take_battery: Callable[[], bool], volume: VolumeOfFlight) -> None:
        self._loop, self._take_battery, self._volume = loop, take_battery, volume
        self._stopover = Stopover()
        self._must_swap = False

    @property
    def is_under_way(self) -> bool:
        """Whether it lands, stands or takes off."""
        return self._stopover.is_under_way

    def begin(self) -> None:
        """Order to land."""
        self._stopover.begin()
        self._loop.monitor.land_between()
        self._loop.land()

    def follow(self, here_m: np.ndarray) -> bool:
        """Do what is due; call it at each step. Return whether the UAV hovers again, once.

        here_m: (3,) x, y, z of the UAV in the map's frame.
        """
        loop = self._loop
        if self._stopover.on_armed(loop.is_armed):
            self._must_swap = self._take_battery()
            if not self._must_swap:
                loop.abort("There is no full battery.")
        if self._must_swap:
            try:
                if loop.simulation.power is not None:  # an endless battery is not swapped
                    loop.simulation.swap_battery()
            except SimulationError:
                return False  # the rotors still turn
            self._must_swap = False
            self._take_off(here_m)
        if not self._stopover.on_ready(loop.publisher.ready):
            return False
        loop.monitor.fly_on()
        return True

    def _take_off(self, here_m: np.ndarray) -> None:
        loop, usual = self._loop, self._loop.publisher.parameters
        room_m = self._volume.room_above_m(here_m, usual.hover_height_m)
        try:
            loop.publisher.restart(hover_height_m(room_m, usual.hover_height_m, usual.ground_clearance_m))
        except FlightError as error:
            loop.abort(str(error))
            return
        self._stopover.take_off()
