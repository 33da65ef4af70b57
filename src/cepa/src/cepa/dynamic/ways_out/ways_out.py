"""What the UAV does where no usual answer will do: leave, make way, brake hard, climb on the spot."""

from __future__ import annotations

import math

import numpy as np

from cepa.decision import Reason
from cepa.dynamic.candidates import STANDSTILL, Chosen, candidates
from cepa.dynamic.constants.choice import HARD_BRAKING_FROM_M_S, SPOT_CLIMBS, STANDS_M_S
from cepa.dynamic.cost import Cost
from cepa.dynamic.kernels.surroundings import NO_COST_TO_GO, Surroundings
from cepa.dynamic.knowledge import Outlook, Step
from cepa.dynamic.rollouts import Rollouts
from cepa.dynamic.threats import is_hurried, is_within
from cepa.dynamic.ways_out.emergency import Emergency
from cepa.dynamic.ways_out.hard_braking import hardest_braking
from cepa.dynamic.ways_out.way_aside import WayAside
from cepa.parameters import CepaParameters


class WaysOut:
    """Tells when a way out is needed, and chooses it."""

    def __init__(self, parameters: CepaParameters, rollouts: Rollouts, cost: Cost):
        self._p, self._rollouts, self._cost = parameters, rollouts, cost
        self._way_aside = WayAside(parameters, rollouts, cost)
        self._emergency = Emergency(parameters, rollouts.hull_m)

    def reset(self) -> None:
        """Forget that it is an emergency."""
        self._emergency.reset()
        self._way_aside.reset()

    def must_leave(self, around: Surroundings, progress_m: float, speed: float, end_m: float) -> bool:
        """Return whether it is an emergency; see `Emergency.is_needed`."""
        return self._emergency.is_needed(around, progress_m, speed, end_m)

    def leave(self, step: Step, outlook: Outlook) -> Chosen:
        """Return the admissible velocity that regains r_LB fastest; the hull's own margin must suffice."""
        p, speed = self._p, max(step.reference.speed, self._p.v_max)
        around = outlook.around._replace(cost_to_go=NO_COST_TO_GO)
        way_out, climb_m = self._emergency.way_out(around), self._emergency.climb_m(around)
        if is_within(step.snapshot.observed.columns) or self._is_of_unknown_height(step):
            climb_m = math.inf  # out to the side, never between a load and the floor
        if abs(climb_m) * p.v_max < (way_out.length_m if way_out else math.inf) * p.climb_max:
            climb = self._spot_climb(step, around, climb_m, is_emergency=True)
            if climb is not None:
                return Chosen(climb, 0.0, len(SPOT_CLIMBS), Reason.MARGIN_LOST)
        away = np.zeros(2) if way_out is None else way_out.direction
        commands = candidates(np.array([*(p.v_max * away), 0.0]), step.last_command, speed)
        commands = step.with_climbs(commands, 0.0)
        flown = commands, step.snapshot.state, around, away, step.commit_s
        assessed = self._rollouts.assess(*flown, is_emergency=True)
        cost = self._cost.of_leaving(commands, assessed.outcomes, step.last_command, way_out is not None)
        cost[~assessed.is_admissible] = math.inf
        best = int(np.argmin(cost)) if np.isfinite(cost).any() else STANDSTILL
        return Chosen(commands[best], float(cost[best]), len(commands), Reason.MARGIN_LOST)

    def make_way(self, step: Step, outlook: Outlook, shown: np.ndarray) -> Chosen | None:
        """Leave the columns that something comes down into soonest, to any side; see `WayAside.choose`.

        None: the UAV need not leave yet. Nothing comes soon, and the way out is short.
        """
        columns, around = step.snapshot.observed.columns, outlook.around
        past = self._way_aside.way_past(around, columns)
        if past is None and not is_hurried(columns, self._p.body_radius):
            return None
        return self._way_aside.choose(step, around, shown, past)

    def brake_hard(self, step: Step, tested: int) -> Chosen:
        """Brake as hard as the UAV can. tested: so many candidates."""
        hardest = hardest_braking(step.snapshot.state[:2, 1], self._p.response)
        return Chosen(hardest, math.inf, tested, Reason.BRAKING)

    def climb_on_the_spot(self, step: Step, outlook: Outlook) -> Chosen:
        """Climb or sink as fast as may be, to look for a way at other heights."""
        climb, tested = self._spot_climb(step, outlook.around, outlook.search_climb), len(SPOT_CLIMBS)
        if climb is not None:
            return Chosen(climb, 0.0, tested, Reason.STEERED)
        if not np.any(np.abs(step.snapshot.state[:, 1]) > STANDS_M_S):
            step.knowledge.give_up_height()
        return Chosen(np.zeros(3), math.inf, tested, Reason.BRAKING)

    def _spot_climb(
        self, step: Step, around: Surroundings, sign: float, is_emergency: bool = False
    ) -> np.ndarray | None:
        """Return the fastest admissible climb on the spot (3,), m/s; sign < 0: down. None: there is none."""
        commands = np.zeros((len(SPOT_CLIMBS), 3))
        commands[:, 2] = math.copysign(self._p.climb_max, sign) * np.array(SPOT_CLIMBS)
        state, nowhere = step.snapshot.state, np.zeros(2)
        assessed = self._rollouts.assess(commands, state, around, nowhere, step.commit_s, is_emergency)
        is_admissible = assessed.is_admissible
        return commands[is_admissible.argmax()] if is_admissible.any() else None

    def _is_of_unknown_height(self, step: Step) -> bool:
        """Return whether a plane shows what is within r_LB: it may be there at other heights, too."""
        if not step.knowledge.knows_one_height:
            return False
        near_m = np.hypot(*step.snapshot.near.T).min(initial=math.inf)
        return bool(near_m < self._p.r_lb)


def must_brake_hard(step: Step) -> bool:
    """Return whether the UAV is fast, and a plane alone shows what stands before it.

    Clouds show ways over and under it, so that standing is the worst of many.
    """
    state = step.snapshot.state
    own_speed = math.hypot(state[0, 1], state[1, 1])
    return own_speed > HARD_BRAKING_FROM_M_S and step.knowledge.knows_one_height
