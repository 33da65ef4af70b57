"""Compiles explorer and path planner ahead of use."""

from __future__ import annotations

import numpy as np

from inspection_tools.exploration.explorer import Explorer
from inspection_tools.exploration.parameters import ExplorerParameters
from inspection_tools.planning.warm_up import planner_in_free_space, warm_up_planning


def warm_up_exploration() -> None:
    """Look for a view in a small space, with the usual parameters and with such as see nothing."""
    warm_up_planning()
    planner, _ = planner_in_free_space()
    here = np.array((0.9, 1.5, 1.5))
    for parameters in (ExplorerParameters(), ExplorerParameters(rate_min=1e3, reach=0.5)):
        Explorer(parameters).decide(planner.space(0.0, here), here)
