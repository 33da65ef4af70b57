"""What the watch over the energy is made with."""

from __future__ import annotations

from dataclasses import dataclass

from inspection_tools.checks import check_number
from inspection_tools.errors import ParameterError


@dataclass(frozen=True)
class EnergyParameters:
    """Reserves and times. A charge is a share of the full battery, 0..1.

    Attributes:
        reserve: Charge that is left after the landing at home.
        land_at: Charge at which the UAV lands where it is.
        margin: What the way home may take, as a multiple of its cost at the mean rate: head wind, detours.
        landing_time: Time that the landing takes, s.
        endurance: Time in which a full battery gets empty, s. It counts until the battery has told the rate.
        rate_window: Time over which the rate is measured, s.
        resolution: Step of the charge that is told; MAVLink's is 1 %.
        largest_rise: A reading that is higher than the last one by more than this is not believed.
        largest_fall: A reading that is lower than the reckoned charge by more than this is believed when the
            next one confirms it.
        held_at: A simulated battery stays at this charge (PX4's SIM_BAT_MIN_PCT), so it counts as it is told
            there and is not reckoned on. 0: none does.
        timeout: A battery that has told nothing for so long counts as silent, s. PX4 tells it every 2 s.

    Raises:
        ParameterError: a value out of range, or a reserve that is not above land_at.
    """

    reserve: float = 0.12
    land_at: float = 0.05
    margin: float = 1.3
    landing_time: float = 10.0
    endurance: float = 600.0
    rate_window: float = 90.0
    resolution: float = 0.01
    largest_rise: float = 0.05
    largest_fall: float = 0.05
    held_at: float = 0.0
    timeout: float = 6.0

    def __post_init__(self) -> None:
        check_number("reserve", self.reserve, 0.0, 0.9)
        check_number("land_at", self.land_at, 0.0, 0.9)
        check_number("margin", self.margin, 1.0, 5.0)
        check_number("landing_time", self.landing_time, 0.0, 600.0)
        check_number("endurance", self.endurance, 10.0, 86_400.0)
        check_number("rate_window", self.rate_window, 1.0, 3600.0)
        check_number("resolution", self.resolution, 0.0, 0.1)
        check_number("largest_rise", self.largest_rise, 0.0, 1.0)
        check_number("largest_fall", self.largest_fall, 0.0, 1.0)
        check_number("held_at", self.held_at, 0.0, 1.0)
        check_number("timeout", self.timeout, 0.1, 60.0)
        if self.reserve <= self.land_at:
            raise ParameterError(
                f"reserve is {self.reserve:g}; it must be above land_at, {self.land_at:g}, or the UAV lands "
                "before it turns back."
            )
