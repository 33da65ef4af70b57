"""What the watch over the energy is made with."""

from __future__ import annotations

from dataclasses import dataclass

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ParameterError


@dataclass(frozen=True)
class EnergyParameters:
    """Reserves and times. A charge is a share of the full battery, 0..1.

    Raises:
        ParameterError: a value out of range, or a reserve that is not above land_at.
    """

    reserve: float = limited(0.12, 0.0, 0.9)
    """Charge that is left after the landing at home."""
    land_at: float = limited(0.05, 0.0, 0.9)
    """Charge at which the UAV lands where it is."""
    margin: float = limited(1.3, 1.0, 5.0)
    """What the way home may take, as a multiple of its cost at the mean rate: head wind, detours."""
    settling_time: float = limited(8.0, 0.0, 600.0)
    """Time that each way home takes besides, s: to brake and turn round, and to come to rest over home. On a
    short way it is most of the time.
    """
    landing_time: float = limited(10.0, 0.0, 600.0)
    """Time that the landing takes, s."""
    endurance: float = limited(600.0, 10.0, 86_400.0)
    """Time in which a full battery gets empty, s. It counts until the battery has told the rate."""
    rate_window: float = limited(90.0, 1.0, 3600.0)
    """Time over which the rate is measured, s."""
    resolution: float = limited(0.01, 0.0, 0.1)
    """Step of the charge that is told; MAVLink's is 1 %."""
    largest_rise: float = limited(0.05, 0.0, 1.0)
    """A reading that is higher than the last one by more than this is not believed."""
    largest_fall: float = limited(0.05, 0.0, 1.0)
    """A reading that is lower than the reckoned charge by more than this is believed when the next one
    confirms it.
    """
    held_at: float = limited(0.0, 0.0, 1.0)
    """A simulated battery stays at this charge (PX4's SIM_BAT_MIN_PCT), so it counts as it is told there and
    is not reckoned on. 0: none does.
    """
    timeout: float = limited(6.0, 0.1, 60.0)
    """A battery that has told nothing for so long counts as silent, s. PX4 tells it every 2 s."""

    def __post_init__(self) -> None:
        check_parameters(self)
        if self.reserve <= self.land_at:
            raise ParameterError(
                f"reserve is {self.reserve:g}; it must be above land_at, {self.land_at:g}, or the UAV lands "
                "before it turns back."
            )
