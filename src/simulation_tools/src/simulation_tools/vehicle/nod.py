"""The sweep with which a lidar nods: its plane tilts about level, so that it sees a volume."""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass

from flight_basics.checks import check_limits, limited
from simulation_tools.errors import SimulationToolsError


class NodError(SimulationToolsError):
    """A sweep makes no sense."""


@dataclass(frozen=True)
class Nod:
    """A sine, so that motors need no jumps of speed. amplitude_rad: 0 is level. period_s: of one whole sweep.

    sweeps: number of whole sweeps, after which it ends, level; 0: no end.

    Raises:
        NodError: a value is not finite, the amplitude or the number negative, or the period not above 0.
    """

    amplitude_rad: float = limited(MISSING, 0.0)
    period_s: float = limited(MISSING, above=0.0)
    sweeps: int = limited(0, 0)

    def __post_init__(self) -> None:
        check_limits(self, NodError, "The {} of a nod")

    @property
    def greatest_rate_rad_s(self) -> float:
        """Rate at which it passes level."""
        return math.tau * self.amplitude_rad / self.period_s

    def is_over(self, time_s: float) -> bool:
        """Whether it has ended by a time after its begin, s."""
        return self.sweeps > 0 and time_s >= self.sweeps * self.period_s

    def angles_at(self, time_s: float) -> tuple[float, float]:
        """Return roll and pitch at a time after its begin, rad. It begins downwards.

        Sweeps turn about pitch and roll by turns, because beams along the axis stay where they are.
        """
        angle_rad = self.amplitude_rad * math.sin(math.tau * time_s / self.period_s)
        turns_roll = int(time_s // self.period_s) % 2 == 1
        return (angle_rad, 0.0) if turns_roll else (0.0, angle_rad)
