"""Loop closure: the optional back end that corrects the whole path. See doc/loop_closure.md.

Its stages are files: `snapshot` -> `candidates` -> `matches` -> `consistent_set` -> `correction`.
`stages` runs them on a snapshot, and `closer` decides when, beside the filter. What they measure with lies in
folders: `path`, `links` and `local_maps`. The criterion of a closure is in `matches`.
"""

from gridslam.loop_closure.edges import Closure
from gridslam.loop_closure.parameters import LoopClosureParameters

__all__ = ["Closure", "LoopClosureParameters"]
