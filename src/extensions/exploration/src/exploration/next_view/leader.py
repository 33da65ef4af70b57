"""The exploration as a leader of an errand: see `flight_basics.errand.leader`."""

from __future__ import annotations

import math
from typing import Any, Callable, Mapping

import numpy as np

from exploration.energy import EnergyWatch
from exploration.next_view.exploration import Exploration
from exploration.next_view.explorer import Explorer
from exploration.next_view.parameters import ExplorationParameters
from exploration.planning import PathPlanner
from flight_basics.errand.forwarding import ForwardingLeader
from flight_basics.errand.leader import Here, Outcome


class ExplorationLeader(ForwardingLeader[Exploration]):
    """Explores. With a new goal it goes on with what is known.

    `Here.more` is the variance of the height as odometry tells it, m2.

    Args:
        planner, explorer, parameters, energy, smaller: as those of `Exploration`. note_place: told each place
            (x, y, z) of the UAV. say: told what is wrong, in a sentence.
    """

    is_busy = False

    def __init__(
        self,
        planner: PathPlanner,
        explorer: Explorer,
        parameters: ExplorationParameters,
        energy: EnergyWatch | None,
        smaller: Mapping[str, float],
        note_place: Callable[[np.ndarray], None] = lambda _: None,
        say: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._make = lambda: Exploration(planner, explorer, parameters, energy, smaller)
        self._planner, self._energy = planner, energy
        self._note_place, self._say = note_place, say
        super().__init__(energy)

    @property
    def exploration(self) -> Exploration | None:
        """What flies the goal; None: no goal has come."""
        return self.led

    @property
    def setpoint(self) -> np.ndarray | None:
        """Where to fly, (x, y, z); None: nowhere yet."""
        return None if self.exploration is None else self.exploration.setpoint_m

    @property
    def end(self) -> str:
        """Why it has ended, in a word; empty: it has not."""
        end = None if self.exploration is None else self.exploration.explored.end
        return "" if end is None else end.value

    @property
    def reason(self) -> str:
        """Why it has ended, in a sentence."""
        return self._it.explored.reason

    @property
    def has_map(self) -> bool:
        """Whether a map has come."""
        return self._planner.has_map

    @property
    def rate_per_s(self) -> float:
        """Share of the charge that a second takes; NaN: not known."""
        return math.nan if self._energy is None else self._energy.rate_per_s

    def prepare(self, content: Any) -> float | None:
        """Return the time of a goal, s; None: the parameter's."""
        return content.time_max or None

    def begin(self, plan: float | None, here: Here | None, kept: Mapping[str, Any] | None) -> str:
        """Begin. Raises ParameterError: the time makes no sense."""
        assert here is not None
        self._begin(self.exploration or self._make(), plan, here, kept)
        x_m, y_m, z_m = here.place_m
        return f"The exploration begins at ({x_m:.1f}, {y_m:.1f}, {z_m:.1f})."

    def note(self, here: Here) -> None:
        """Take where the UAV is."""
        self._note_place(here.place_m)

    def follow(self, here: Here) -> bool:
        """Follow the way."""
        sentence = self._it.explored.note_height(math.sqrt(here.more) if here.more >= 0.0 else math.nan)
        if sentence:
            self._say(sentence)
        return self._it.follow(here.time_s, here.place_m)

    def rest(self) -> None:
        """Nothing is to be done."""

    def stop_waiting(self) -> str:
        """Nothing goes on while nothing is flown."""
        return ""

    def outcome(self) -> Outcome | None:
        """Return the end of the exploration: at home, or where the UAV must land."""
        it = self._it
        if not (it.is_home or it.must_land):
            return None
        words = " ".join(filter(None, (it.explored.reason, it.explored.height_words)))
        log = f"The UAV {'is home' if it.is_home else 'is not home'}. {words}"
        return Outcome(words, must_land=it.must_land, log=log)
