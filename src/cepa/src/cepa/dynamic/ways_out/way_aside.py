"""The way out from under what comes down, or from over what rises: to the side, soonest."""

from __future__ import annotations

import math

import numpy as np

from cepa.decision import Reason
from cepa.dynamic.candidates import STANDSTILL, Chosen, candidates
from cepa.dynamic.constants.choice import (
    EVASION_M_S,
    HURRIED_BY_CLOUDS_S,
    HURRIED_EVASION_M_S,
    NOT_COME_S,
    RIM_M,
    SINK_ALONG_S,
)
from cepa.dynamic.constants.obstacle_tracks import UPRIGHT_COSINE
from cepa.dynamic.constants.response import CLIMB_LAG_S
from cepa.dynamic.cost import Cost
from cepa.dynamic.kernels.rollout import LOSS
from cepa.dynamic.kernels.surroundings import NO_COST_TO_GO, Surroundings
from cepa.dynamic.knowledge import Observation, Snapshot, Step
from cepa.dynamic.rollouts import Rollouts
from cepa.dynamic.threats import are_within, arrives_in_s
from cepa.dynamic.ways_out.straight_ways import straight_ways
from cepa.motion import Ranging
from cepa.parameters import CepaParameters


class WayAside:
    """Leaves the columns that something comes down into, or rises in; see `Observation`."""

    def __init__(self, parameters: CepaParameters, rollouts: Rollouts, cost: Cost):
        self._p, self._rollouts, self._cost = parameters, rollouts, cost
        self.reset()

    def reset(self) -> None:
        """Forget the way past what stands."""
        self._last = np.zeros(2)

    def way_past(self, around: Surroundings, columns: np.ndarray) -> np.ndarray | None:
        """Return the direction (2,) of a straight flight out of the columns, past what stands.

        None: the UAV is in no column, or the shortest flight out is free, or no straight flight is. It
        remembers its last direction, so it is asked once a step.
        """
        within = columns[np.hypot(columns[:, 0], columns[:, 1]) < columns[:, 4]]
        if not len(within):
            self._last = np.zeros(2)
            return None
        ways = straight_ways(around.field)
        places = ways.steps_m[:, None, None] * ways.directions
        rim_m = within[:, 4] + self._p.body_radius
        away_m = np.hypot(places[..., 0, None] - within[:, 0], places[..., 1, None] - within[:, 1])
        is_out = (away_m >= rim_m).all(axis=-1)
        is_open = ways.narrowest_m >= min(self._rollouts.hull_m, ways.here_m)
        way = ways.soonest(is_out & is_open, self._p.r_lb, self._last)
        shortest = int(is_out.any(axis=1).argmax()) if is_out.any() else len(is_out) - 1
        is_blocked = not is_open[shortest, is_out[shortest]].any()
        self._last = np.zeros(2) if way is None or not is_blocked else way.direction
        return self._last if self._last.any() else None

    def choose(self, step: Step, around: Surroundings, shown: np.ndarray, past: np.ndarray | None) -> Chosen:
        """Return the admissible velocity that leaves the columns soonest, to any side.

        A flight that would end at what stands stays within the columns for the rest of the horizon. Where
        something stands in the way of the shortest flight out, it follows the shortest past it, also if that
        leads through the middle. By its lean the UAV rises and sinks a little; that leads to no other height.
        It sinks on its way out only if something is about to touch it. shown (k, 8): of the columns those
        that tell how soon it must be gone. past: see `way_past`.
        """
        snapshot, last_command, commit_s = step.snapshot, step.last_command, step.commit_s
        observed, p = snapshot.observed, self._p
        columns, movers = _over(observed.columns[:, :6], p.body_radius), observed.movers
        others = movers[~are_within(movers, columns)]  # a scan may show the thing itself, as it sinks
        movers = others if past is not None else np.concatenate((others, columns))
        around = around._replace(cost_to_go=NO_COST_TO_GO, movers=movers)
        speed = max(step.reference.speed, self._evasion_m_s(observed, shown))
        away = np.zeros(2) if past is None else past
        led = step.reference.velocity if past is None else np.array([*(speed * past), 0.0])
        commands = candidates(led, last_command, speed)
        commands[:, 2] = 0.0
        state = snapshot.state.copy()
        state[2, 1:] = 0.0
        assessed = self._rollouts.assess(commands, state, around, away, commit_s, is_emergency=True)
        lost, here = assessed.outcomes[:, LOSS], self._rollouts.discomfort_in_emergency(around)
        cost = (
            self._cost.of_leaving(commands, assessed.outcomes, last_command, past is not None) + here * lost
        )
        cost[~assessed.is_admissible] = math.inf
        best = int(np.argmin(cost)) if np.isfinite(cost).any() else STANDSTILL
        command = commands[best].copy()
        above_s, below_s = arrives_in_s(observed.columns, p.body_radius)
        if -NOT_COME_S <= above_s <= SINK_ALONG_S < below_s and _can_sink(snapshot, p):
            sinking = np.array((*command[:2], -p.climb_max))
            seen = self._rollouts.assess(sinking[None], state, around, away, commit_s, True)
            command = sinking if seen.is_admissible[0] else command
        return Chosen(command, float(cost[best]), len(commands), Reason.MARGIN_LOST)

    def _evasion_m_s(self, observed: Observation, shown: np.ndarray) -> float:
        """Return how fast the UAV leaves: in no hurry from what clouds show to come slowly."""
        falls_s, _ = arrives_in_s(shown, self._p.body_radius)
        is_slow = observed.cloud is not None and not -NOT_COME_S <= falls_s <= HURRIED_BY_CLOUDS_S
        return EVASION_M_S if is_slow else HURRIED_EVASION_M_S


def _over(columns: np.ndarray, body_m: float) -> np.ndarray:
    """Return columns (c, 6) that hold the middle of a UAV whose body, of this radius, is in them.

    A rim that a fast UAV is about to pass would be a contact at once, whatever it does. Then all ways out
    would be as bad, and it would stop.
    """
    away_m, grown = np.hypot(columns[:, 0], columns[:, 1]), columns.copy()
    grown[:, 4] = np.where(
        away_m < columns[:, 4] + body_m, np.maximum(columns[:, 4], away_m + RIM_M), columns[:, 4]
    )
    return grown


def _can_sink(snapshot: Snapshot, p: CepaParameters) -> bool:
    """Return whether a UAV that sinks now stops in time over the floor, also if it leans and takes longer.

    It stops above `height_min`, and `r_lb` over what a range finder sees below: the floor may rise, or have
    a box on it.
    """
    observed, further_m = snapshot.observed, 2.0 * CLIMB_LAG_S * min(0.0, float(snapshot.state[2, 1]))
    below_m = [
        -r.origin_m[2] - max(r.range_m, 0.0) * r.direction[2] for r in observed.rangings if _is_down(r)
    ]
    above_floor = observed.motion.position_m[2] + further_m > p.height_min
    return above_floor and min(below_m, default=math.inf) + further_m > p.r_lb


def _is_down(ranging: Ranging) -> bool:
    return ranging.direction[2] < -UPRIGHT_COSINE and not math.isnan(ranging.range_m)
