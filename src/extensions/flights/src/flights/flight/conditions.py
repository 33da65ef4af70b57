"""Conditions that are worse than the data sheets say: noise, lost scans, late odometry, wind, rain, glass."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, fields, replace

import numpy as np

from flight_basics.checks import check_limits, limited
from flights.errors import FlightError
from flights.flight.lidar.faults import ALL_ANGLES_DEG, LidarFaults, Pane, panes_of
from simulation_tools.publisher import PublisherParameters
from simulation_tools.sdf.parser import load_world
from simulation_tools.sensors.lidar import Lidar
from simulation_tools.sensors.odometry import OdometrySample
from simulation_tools.simulation import SimulationParameters
from simulation_tools.vehicle.wind import AirStream

_RESTLESS_M, _RESTLESS_M_S = 0.1, 0.06
"""Three standard deviations of PX4's place and speed in hover, for each m/s of such a wind (measured)."""
_WIND, _LOSS, _FAULTS = 1, 2, 3  # random streams beside those of the simulation


@dataclass(frozen=True)
class Conditions:
    """The defaults change nothing.

    lidar_noise_factor: times the standard deviation in the lidar's SDF. scan_loss: share of the scans that
    never arrive. odometry_delay_s: how late odometry arrives. wind_m_s: mean of a wind with gusts; the seed
    of the simulation draws its direction. rain, lost_view, glass_deg: see `LidarFaults`.
    """

    lidar_noise_factor: float = limited(1.0, 0.0, 20.0)
    scan_loss: float = limited(0.0, 0.0, 0.95)
    odometry_delay_s: float = limited(0.0, 0.0, 2.0)
    wind_m_s: float = limited(0.0, 0.0, 20.0)
    rain: float = limited(0.0, 0.0, 0.5)
    lost_view: float = limited(0.0, 0.0, 0.5)
    glass_deg: float = limited(ALL_ANGLES_DEG, 0.0, ALL_ANGLES_DEG)

    def __post_init__(self) -> None:
        check_limits(self, FlightError)

    def applied_to(self, simulation: SimulationParameters) -> SimulationParameters:
        """Return the simulation with this noise and wind."""
        factor = simulation.lidar_noise_factor * self.lidar_noise_factor
        changed = replace(simulation, lidar_noise_factor=factor)
        if self.wind_m_s == 0.0:
            return changed
        direction_rad = _rng(simulation.seed, _WIND).uniform(-math.pi, math.pi)
        return replace(changed, wind=(*simulation.wind, AirStream.gusty(self.wind_m_s, direction_rad)))

    def faults_of(self, simulation: SimulationParameters, lidar: Lidar) -> LidarFaults:
        """Return what spoils the scans of a flight; raises SimulationToolsError if its world cannot be read.

        The seed of the simulation draws rain and lost view.
        """
        panes: list[Pane] = []
        if self.glass_deg < ALL_ANGLES_DEG:
            panes = panes_of(load_world(simulation.world, simulation.model_path))
        faults = self.rain, self.lost_view, self.glass_deg
        return LidarFaults(*faults, panes, lidar, _rng(simulation.seed, _FAULTS))

    def hover_of(self, publisher: PublisherParameters) -> PublisherParameters:
        """Return the publisher's parameters, by which the UAV may hover as restlessly as gusts let it."""
        return replace(
            publisher,
            ready_distance_m=publisher.ready_distance_m + _RESTLESS_M * self.wind_m_s,
            ready_speed_m_s=publisher.ready_speed_m_s + _RESTLESS_M_S * self.wind_m_s,
        )


BOUNDS = {each.name: (each.metadata["least"], each.metadata["most"]) for each in fields(Conditions)}
"""Least and greatest value of each condition."""


class Delivery:
    """Decides which scans arrive, and with which odometry. One object serves one flight."""

    def __init__(self, conditions: Conditions, seed: int) -> None:
        """seed: of the simulation."""
        self._conditions = conditions
        self._rng = _rng(seed, _LOSS)
        self._under_way: deque[tuple[float, OdometrySample]] = deque()

    def scan_arrives(self) -> bool:
        """Tell whether the next scan arrives."""
        loss = self._conditions.scan_loss
        return loss == 0.0 or self._rng.random() >= loss

    def odometry(self, t_s: float, sample: OdometrySample) -> tuple[float, OdometrySample]:
        """Take the sample of an instant; return the newest one that has arrived, and its age in s.

        The first sample is known at once.
        """
        if self._conditions.odometry_delay_s == 0.0:
            return 0.0, sample
        self._under_way.append((t_s, sample))
        latest_s = t_s - self._conditions.odometry_delay_s + 1e-9
        while len(self._under_way) > 1 and self._under_way[1][0] <= latest_s:
            self._under_way.popleft()
        stamp_s, newest = self._under_way[0]
        return t_s - stamp_s, newest


def _rng(seed: int, stream: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence((seed, stream)))
