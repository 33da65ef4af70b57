"""Makes sessions by the parameters: new, on a given map, or from a saved state."""

from __future__ import annotations

import dataclasses
from typing import Callable

from gridslam import SlamParameters
from gridslam.files.map_file import read_map
from gridslam.saved_sessions import load_session
from gridslam.session import SlamSession, closure_parameters
from gridslam_ros.parameters import CLOSURE_PREFIX, sort_parameters


class Sessions:
    """Makes sessions, each from the beginning.

    Args:
        given: parameters by name.
        say: is called with a sentence when something is odd.

    Raises SlamError with one sentence.
    """

    def __init__(self, given: dict, say: Callable[[str], None]):
        self._given, self._say = given, say
        self._settings, self._parameters, closure, _ = sort_parameters(given)
        self._closure = closure_parameters(closure) if self._settings.loop_closure else False
        self._starting_map = read_map(self._settings.starting_map) if self._settings.starting_map else None

    def first(self) -> SlamSession:
        """Return the session for the start of a run, and for a restart after the clock went back."""
        settings = self._settings
        if settings.continue_from_state:
            return self.saved(settings.state_file, settings.starting_pose)
        return SlamSession(
            self._parameters,
            loop_closure=self._closure,
            starting_map=self._starting_map,
            starting_pose=settings.starting_pose or None,
            localisation_only=bool(settings.localisation_only),
            say=self._say,
            odometry_in_space=bool(settings.odometry_in_space),
        )

    @property
    def again(self) -> str:
        """Describes a second call of ``first``, for messages."""
        if self._settings.continue_from_state:
            return "SLAM begins again with the saved state"
        return f"{'localisation' if self._settings.localisation_only else 'mapping'} starts anew"

    def saved(self, path: str, starting_pose: tuple = ()) -> SlamSession:
        """Return the session saved in a file. Report given parameters without effect."""
        session = load_session(
            path,
            self._say,
            localisation_only=bool(self._settings.localisation_only),
            starting_pose=starting_pose or None,
            threads=self._parameters.threads,
            odometry_in_space=bool(self._settings.odometry_in_space),
        )
        kept = kept_by_state(self._given, session)
        if kept:
            self._say(f"The saved state keeps its own {', '.join(kept)}, whatever is given now.")
        return session


def kept_by_state(given: dict, session: SlamSession) -> list[str]:
    """Return the names of given parameters that have no effect on a session from a saved state."""
    settings, parameters, closure, _ = sort_parameters(given)
    kept = [
        field.name
        for field in dataclasses.fields(SlamParameters)
        if field.name in given and getattr(parameters, field.name) != getattr(session.parameters, field.name)
    ]
    theirs = session.loop_closure
    if "loop_closure" in given and bool(settings.loop_closure) != (theirs is not None):
        kept.append("loop_closure")
    if theirs is not None:
        kept += [CLOSURE_PREFIX + name for name in closure if closure[name] != getattr(theirs, name, None)]
    if session.localisation_only and "localisation_only" in given and not settings.localisation_only:
        kept.append("localisation_only")
    if settings.starting_pose and session.slam is not None:  # else the session begins there
        kept.append("starting_pose")
    if settings.starting_map:
        kept.append("starting_map")
    return kept
