"""An inspection that is flown: the photographs of a plan, one after the other. It needs numba."""

from inspection.flight.inspection import End, Inspection
from inspection.flight.parameters import InspectionParameters
from inspection.flight.photograph_quality import PhotographQuality
from inspection.flight.photograph_queue import PhotographQueue, Task
from inspection.flight.prior_map import PriorMap

__all__ = [
    "End",
    "Inspection",
    "InspectionParameters",
    "PhotographQuality",
    "PhotographQueue",
    "PriorMap",
    "Task",
]
