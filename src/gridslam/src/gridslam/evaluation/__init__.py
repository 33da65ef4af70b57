"""The errors of a trajectory or a map against the truth. See doc/reference.md."""

from gridslam.evaluation.map_error import MapAccuracy, map_error
from gridslam.evaluation.map_picture import draw_map_error, map_error_figure
from gridslam.evaluation.relations import Relations, read_relations, relation_errors
from gridslam.evaluation.trajectory_error import TrajectoryError, trajectory_error
from gridslam.evaluation.walls import WallPoints, Walls, read_walls
from gridslam.files.tum import poses_at, read_tum, write_tum

__all__ = [
    "MapAccuracy",
    "Relations",
    "TrajectoryError",
    "WallPoints",
    "Walls",
    "draw_map_error",
    "map_error",
    "map_error_figure",
    "poses_at",
    "read_relations",
    "read_tum",
    "read_walls",
    "relation_errors",
    "trajectory_error",
    "write_tum",
]
