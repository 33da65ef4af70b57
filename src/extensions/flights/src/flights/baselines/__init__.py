"""Other avoidance algorithms to compare CEPA with, each in its plain published form.

They answer the same question as CEPA's algorithms (scan, reference velocity and own velocity in, velocity
out), so that the closed loop flies them unchanged. None of them is the authors' own code.
"""

from flights.baselines.collision_prevention import CollisionPrevention, CollisionPreventionParameters
from flights.baselines.no_avoidance import NoAvoidance
from flights.baselines.vfh_plus import VfhPlus, VfhPlusParameters
from flights.baselines.vfh_plus_3d import VfhPlus3d, VfhPlus3dParameters

BASELINES = {
    "none": NoAvoidance,
    "collision_prevention": CollisionPrevention,
    "vfh_plus": VfhPlus,
    "vfh_plus_3d": VfhPlus3d,
}
"""The baselines by the names that campaigns use."""

__all__ = [
    "BASELINES",
    "CollisionPrevention",
    "CollisionPreventionParameters",
    "NoAvoidance",
    "VfhPlus",
    "VfhPlus3d",
    "VfhPlus3dParameters",
    "VfhPlusParameters",
]
