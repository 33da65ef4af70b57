"""Loop closure: the optional back end that corrects the whole path. See doc/loop_closure.md."""

from gridslam.loop_closure.closer import LoopCloser
from gridslam.loop_closure.edge import Closure
from gridslam.loop_closure.parameters import LoopClosureParameters

__all__ = ["Closure", "LoopCloser", "LoopClosureParameters"]
