"""The complete state of a run: filter, odometry, tracking, search and loop closure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gridslam.filter.state import FilterState
from gridslam.inputs.continuous_odometry import OdometryState
from gridslam.inputs.slice_watch import SliceState
from gridslam.localisation.supervisor import SupervisorState
from gridslam.tracking.monitor import MonitorState

if TYPE_CHECKING:
    from gridslam.loop_closure.closer import CloserState  # which slows the start


@dataclass(frozen=True, eq=False)
class SessionState:
    """A `SlamSession` that is built from this goes on exactly as the original would."""

    filter: FilterState
    odometry: OdometryState
    tracking: MonitorState
    supervisor: SupervisorState
    slices: SliceState
    closer: CloserState | None
    """None: no loops are closed."""
