"""An inspection that is flown: the photographs of a plan, one after the other. It needs numba."""

from inspection_tools.inspection.inspection import End, Inspection
from inspection_tools.inspection.parameters import InspectionParameters
from inspection_tools.inspection.prior_map import PriorMap
from inspection_tools.inspection.todo import Shot, Task, Todo

__all__ = ["End", "Inspection", "InspectionParameters", "PriorMap", "Shot", "Task", "Todo"]
