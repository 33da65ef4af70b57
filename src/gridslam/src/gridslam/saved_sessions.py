"""Sessions in files: a run goes on from its saved state, or localises on the map of it."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Callable

from gridslam.files import state_file
from gridslam.filter.grid_slam import GridSlam
from gridslam.session import SlamSession
from gridslam.session_state import SessionState


def save_session(session: SlamSession, path: str | Path) -> None:
    """Write a session's complete state. A run from this state equals one that was never interrupted.

    Raises:
        StateError: there is nothing to save yet, or the file cannot be written.
    """
    state_file.write(session.state(), path)


def load_session(
    path: str | Path,
    say: Callable[[str], None] = warnings.warn,
    localisation_only: bool = False,
    starting_pose: tuple[float, float, float] | None = None,
    threads: int | None = None,
    odometry_in_space: bool = False,
) -> SlamSession:
    """Return a saved session with its saved parameters.

    Args:
        path: of the state.
        say: as for a new session.
        localisation_only: use the saved map for localisation only and do not change it. The path begins anew.
        starting_pose: with localisation_only, the vehicle's pose at the first scan; None: the saved pose.
        threads: for this run; None: the saved number.
        odometry_in_space: of this run; see `SlamSession`.

    Raises:
        StateError: the file cannot be read, or holds no state.
    """

    def build(state: SessionState) -> SlamSession:
        if localisation_only and not state.filter.localisation_only:
            mapped = GridSlam.from_state(state.filter, threads)
            pose = mapped.base_in_map if starting_pose is None else starting_pose
            return SlamSession(mapped.parameters, None, mapped, pose, localisation_only=True, say=say)
        return SlamSession.from_state(state, say, threads, odometry_in_space)

    return state_file.read(path, build)
