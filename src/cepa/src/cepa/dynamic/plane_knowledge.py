"""What a UAV with a planar lidar knows of its surroundings, at its own height."""

from __future__ import annotations

import numpy as np

from cepa.dynamic.cost_to_go.course import Course, Reference
from cepa.dynamic.cost_to_go.search import CostToGoSearch
from cepa.dynamic.free_space.planar_sensors import LidarPlane
from cepa.dynamic.kernels.distance_field import fill_distances
from cepa.dynamic.kernels.surroundings import (
    NO_COST_TO_GO,
    CostToGo,
    DistanceField,
    FreeSpace,
    Surroundings,
)
from cepa.dynamic.knowledge import Knowledge, Observation, Outlook, Snapshot
from cepa.dynamic.remembered.field_grid import field_grid_of
from cepa.dynamic.remembered.plane_memory import PlaneMemory, RecalledPlane
from cepa.dynamic.rollouts import Rollouts, cost_horizon_s
from cepa.dynamic.threats import fronts
from cepa.parameters import CepaParameters

NOTHING_UNSEEN = np.empty((0, 0, 0), np.uint8)


class PlaneKnowledge(Knowledge):
    """Knows the newest scan, and what earlier scans have shown.

    search: for the cost-to-go; None: it is not searched.
    """

    def __init__(self, parameters: CepaParameters, rollouts: Rollouts, search: CostToGoSearch | None):
        self._p, self._rollouts, self._search = parameters, rollouts, search
        self._memory = PlaneMemory(parameters)
        self._grid = grid = field_grid_of(parameters)
        self.far_m = parameters.r_ub + grid.cell_m
        """The greatest distance in the field."""
        self._distance = np.empty((1, grid.side, grid.side))

    def reset(self) -> None:
        """Forget what was seen."""
        self._memory.reset()

    def take_over(self, earlier: PlaneKnowledge) -> None:
        """Take over what one with other parameters knows."""
        self._memory.take_over(earlier._memory)

    def take_in(self, observed: Observation) -> Snapshot:
        """Take in what came with a scan."""
        self._memory.keep(observed.standing, observed.free, observed.motion)
        return Snapshot(observed, observed.standing[:, :2], observed.state)

    def lidar_plane(self, observed: Observation) -> LidarPlane:
        """Take in what came with a scan; return what the lidar's plane shows, for `SpaceKnowledge`.

        At another height it sees past what stands below or above, so one such scan is enough to forget that.
        """
        self._memory.keep(observed.standing, observed.free, observed.motion)
        recalled = self._memory.recall(observed.standing, observed.free, observed.motion, patience=1)
        return LidarPlane(observed.free.free_m, self._distances(recalled))

    def clear_reference(self, snapshot: Snapshot, reference: Reference, commit_s: float) -> np.ndarray | None:
        """Return the reference as a command if its path is clear; see `Knowledge`."""
        p, observed, motion = self._p, snapshot.observed, snapshot.observed.motion
        leads_away = is_leading_away(self._search, reference, p)
        if len(observed.threats) or leads_away or self._memory.is_astray:
            return None
        if not self._rollouts.is_clear(reference, snapshot, commit_s):
            return None
        if self._memory.knows_near(cost_horizon_s(p) * reference.velocity[:2], motion):
            return None
        return reference.velocity

    def outlook(self, snapshot: Snapshot, reference: Reference, course: Course) -> Outlook:
        """Return the clearances, the free space and the cost-to-go around the UAV."""
        observed = snapshot.observed
        known = observed.standing, observed.free, observed.motion
        recalled = self._memory.recall(*known, must_flee=len(observed.threats) > 0)
        field = DistanceField(self._distances(recalled), self._grid.cell_m, 1.0, self.far_m)
        cost_to_go: CostToGo | None = NO_COST_TO_GO
        if self._search is not None and reference.speed >= self._p.reference_speed_min:
            obstacles = recalled.obstacles
            if len(observed.threats) > 1:
                obstacles = np.concatenate((obstacles, fronts(observed.threats)))
            cost_to_go = self._search.search(obstacles, course, observed.motion).cost_to_go
        free_space = FreeSpace(recalled.reach_m, NOTHING_UNSEEN, 1.0)
        around = Surroundings(field, free_space, observed.threats, cost_to_go or NO_COST_TO_GO)
        return Outlook(
            around,
            has_way=cost_to_go is not None,
            remembered=recalled.remembered,
            is_hidden=recalled.is_hidden,
            blind_way=recalled.blind_way,
        )

    def with_climbs(self, level: np.ndarray, climb_m_s: float) -> np.ndarray:
        """Return ``level``: in the plane the UAV does not climb."""
        del climb_m_s
        return level

    def remembered(self, snapshot: Snapshot) -> tuple[np.ndarray, np.ndarray]:
        """Return all remembered points (n, 3), m, and which are hidden (n,). It changes nothing."""
        observed = snapshot.observed
        recalled = self._memory.recall(observed.standing, observed.free, observed.motion, forgets=False)
        return recalled.remembered, recalled.is_hidden

    def give_up_height(self) -> None:
        """Do nothing: in the plane no other height is tried."""

    @property
    def knows_one_height(self) -> bool:
        """Whether ways are known at the height of flight only: always."""
        return True

    def _distances(self, recalled: RecalledPlane) -> np.ndarray:
        """Return the field (1, n, n) of the distance to what is seen or hidden, m; it is overwritten."""
        fill_distances(recalled.obstacles, 0.0, 0.0, self._distance[0], self._grid.cell_m, self.far_m)
        return self._distance


def is_leading_away(search: CostToGoSearch | None, reference: Reference, p: CepaParameters) -> bool:
    """Whether the last way out did not begin towards the reference, so that it must be searched again."""
    if search is None or not search.leads_away:
        return False
    return bool(reference.speed >= p.reference_speed_min)
