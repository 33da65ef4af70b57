"""Every class that stands in a saved state. If you change one's fields, count up `state_file.FORMAT`."""

from __future__ import annotations

from gridslam.filter.kept.earlier_map import PiecesState
from gridslam.filter.kept.kept_scans import InSpace
from gridslam.filter.motion_model import MotionState
from gridslam.filter.state import FilterState
from gridslam.inputs.continuous_odometry import OdometryState
from gridslam.inputs.slice_watch import SliceState
from gridslam.inputs.usual_motion import UsualMotionState
from gridslam.level_cloud import LevelCloud
from gridslam.localisation.joined_scans import JoinedScan
from gridslam.localisation.relocaliser import SearchState
from gridslam.localisation.standstill import StandstillState
from gridslam.localisation.supervisor import SupervisorState
from gridslam.loop_closure.closer import CloserState, PendingState
from gridslam.loop_closure.consistent_set import MatchSet
from gridslam.loop_closure.edges import Closure, Edges, Match
from gridslam.loop_closure.links.scan_links import ScanLinksState
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.path.step_uncertainty import DoubtfulNodes
from gridslam.loop_closure.stages import StagesState
from gridslam.maps.new_map import Band
from gridslam.maps.newest_scans import NewestScan
from gridslam.maps.tile_map import MapsState
from gridslam.maps.tile_pool import TilesState
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan
from gridslam.session_state import SessionState
from gridslam.tracking.monitor import MonitorState
from gridslam.tracking.self_check import SelfCheck
from gridslam.trajectory import TreeState

SAVED_CLASSES: tuple[type, ...] = (
    Band,
    CloserState,
    Closure,
    DoubtfulNodes,
    Edges,
    FilterState,
    InSpace,
    JoinedScan,
    LevelCloud,
    LoopClosureParameters,
    MapsState,
    Match,
    MatchSet,
    MeasuredPath,
    MonitorState,
    MotionState,
    NewestScan,
    OccupancyGrid,
    OdometryState,
    PendingState,
    PiecesState,
    PlanarScan,
    ScanLinksState,
    SearchState,
    SelfCheck,
    SessionState,
    SlamParameters,
    SliceState,
    StagesState,
    StandstillState,
    SupervisorState,
    TilesState,
    TreeState,
    UsualMotionState,
)
