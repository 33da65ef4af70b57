"""The map of voxels, which follows loop closures."""

from gridslam.volume.board import Board, Rays
from gridslam.volume.clouds import KeptCloud, Pose
from gridslam.volume.corrected_map import CorrectedMap
from gridslam.volume.correction.rebuilding import Rebuilding
from gridslam.volume.nodes import CloudNode, NodeSpacing
from gridslam.volume.octree.files import read_octree, write_octree
from gridslam.volume.octree.stream import OctreeStream, map_from, stream_of
from gridslam.volume.parameters import FLAT_MISS, VolumeParameters
from gridslam.volume.planning_layers import DistanceField, Frontiers
from gridslam.volume.range_points import RangePoints
from gridslam.volume.scans.gathering import PlacedCloud, ScanGathering
from gridslam.volume.scans.scan_points import carried, points_of_scan
from gridslam.volume.shown_map import FREE, OCCUPIED, UNKNOWN, ShownMap
from gridslam.volume.tile_table import Box
from gridslam.volume.voxel_map import VoxelMap

__all__ = [
    "FLAT_MISS",
    "FREE",
    "OCCUPIED",
    "UNKNOWN",
    "Board",
    "Box",
    "CloudNode",
    "CorrectedMap",
    "DistanceField",
    "Frontiers",
    "KeptCloud",
    "NodeSpacing",
    "OctreeStream",
    "PlacedCloud",
    "Pose",
    "RangePoints",
    "Rays",
    "Rebuilding",
    "ScanGathering",
    "ShownMap",
    "VolumeParameters",
    "VoxelMap",
    "carried",
    "map_from",
    "points_of_scan",
    "read_octree",
    "stream_of",
    "write_octree",
]
