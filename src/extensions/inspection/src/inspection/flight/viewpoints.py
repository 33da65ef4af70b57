"""Which viewpoint of a plan a photograph shows.

Its place and direction tell that. A number does not: it changes when a plan is edited.
"""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from inspection.camera.photograph_pose import PhotographPose
from inspection.photographs.record import PhotographRecord
from inspection.survey.plan import SurveyPlan
from inspection.survey.views.candidates import View

SAME_M, SAME_RAD = 0.002, math.radians(0.02)
"""A plan's file has places to 0.001 m and angles to 0.01 degrees."""
AIM_RAD = math.radians(10.0)
"""A photograph that does not tell its viewpoint shows one whose direction is at most so far from its own."""


class Viewpoints:
    """The photographs of a plan, numbered from 1.

    Args:
        views: of the plan, in its order. far_m: a photograph that does not tell its viewpoint was taken at
            most so far from it.
    """

    def __init__(self, views: Sequence[View], far_m: float) -> None:
        self._rows = np.array([row_of(view) for view in views]).reshape(-1, 5)
        self._aims = np.array([PhotographPose.of_view(view).axes[:, 2] for view in views]).reshape(-1, 3)
        self._far_m = far_m

    def shown_by(self, record: PhotographRecord) -> set[int]:
        """Return the numbers of those that a photograph shows."""
        if record.viewpoint is None:
            off_m = np.linalg.norm(self._rows[:, :3] - record.position_m, axis=1)
            shows = (off_m <= self._far_m) & (self._aims @ record.pose.axes[:, 2] >= math.cos(AIM_RAD))
        else:
            shows = are_same(self._rows, np.array(record.viewpoint))
        return set((np.flatnonzero(shows) + 1).tolist())


def row_of(view: View) -> tuple[float, float, float, float, float]:
    """Return x, y, z in m, yaw and tilt in rad."""
    return (*view.place_m, view.yaw_rad, view.tilt_rad)


def are_same(rows: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return (n,) whether viewpoints (n, 5) are the same as others, (n, 5) or (5,)."""
    off = np.abs(rows - others)
    turned = np.abs(np.remainder(off[:, 3] + math.pi, 2.0 * math.pi) - math.pi)
    return (off[:, :3].max(axis=1) <= SAME_M) & (turned <= SAME_RAD) & (off[:, 4] <= SAME_RAD)


def is_completed(draft: SurveyPlan, whole: SurveyPlan, known: Sequence[View]) -> bool:
    """Whether a plan is what became of a draft.

    known: the draft's photographs, and those that were told since; all of the whole plan, or its first ones.
    """
    given = [(p.source, p.home_m, p.camera, p.asked, p.flying) for p in (draft, whole)]
    count = min(len(known), len(whole.views))
    if draft.draft is None or whole.draft is not None or given[0] != given[1] or count < len(draft.views):
        return False
    rows = [np.array([row_of(view) for view in views[:count]]) for views in (known, whole.views)]
    return bool(are_same(*rows).all())
