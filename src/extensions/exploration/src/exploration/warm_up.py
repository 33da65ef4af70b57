"""Compiles explorer and path planner ahead of use: ``python -m exploration.warm_up``."""

from __future__ import annotations

import numpy as np

from exploration.next_view.explorer import Explorer
from exploration.next_view.kernels.views import sights_of
from exploration.next_view.parameters import ExplorerParameters
from exploration.planning.warm_up import planner_in_free_space, warm_up_planning


def warm_up_exploration() -> None:
    """Look for a view in a small space, with the usual parameters and with such as see nothing."""
    warm_up_planning()
    planner, _ = planner_in_free_space()
    here = np.array((0.9, 1.5, 1.5))
    blind = ExplorerParameters(rate_min=1e3, reach=0.5)
    for parameters in (ExplorerParameters(), blind, ExplorerParameters(view_choice="volume")):
        explorer, space = Explorer(parameters, is_steep=True), planner.space(0.0, here)
        explorer.decide(space, here)
        explorer.left_over(space, space, space, here)
    kinds, voxels = np.ones((1, 1, 1), np.uint8), np.zeros((1, 3), np.int64)
    sights_of(kinds, voxels, voxels, (-1.0, 1.0), (0.0, 1.0))  # that space has no border of room


if __name__ == "__main__":
    warm_up_exploration()
    print("The kernels of planner and explorer are ready.")
