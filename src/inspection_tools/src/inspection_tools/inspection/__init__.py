"""An inspection that is flown: the photographs of a plan, one after the other. It needs numba."""

from inspection_tools.inspection.inspection import End, Inspection
from inspection_tools.inspection.parameters import InspectionParameters
from inspection_tools.inspection.photograph_quality import PhotographQuality
from inspection_tools.inspection.photograph_queue import PhotographQueue, Task
from inspection_tools.inspection.prior_map import PriorMap

__all__ = [
    "End",
    "Inspection",
    "InspectionParameters",
    "PhotographQuality",
    "PhotographQueue",
    "PriorMap",
    "Task",
]
