"""The complete state of one run in one file: filter, odometry, judgement, search and loop closer."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import os
import tempfile
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Iterator, Mapping

import numpy as np

from gridslam.errors import SlamError, StateError, reason_of
from gridslam.files import state_file
from gridslam.filter.particle_filter import GridSlam

if TYPE_CHECKING:
    from gridslam.loop_closure import LoopCloser

FILTER, ODOMETRY, JUDGEMENT = "filter", "odometry.json", "judgement.json"
CLOSER, CLOSER_PARAMETERS = "closer.npz", "closer.json"
SUPERVISOR = "supervisor.npz"


def write(
    path: str | Path,
    slam: GridSlam,
    odometry: dict,
    supervisor: Mapping[str, np.ndarray],
    closer: LoopCloser | None,
) -> None:
    """Write the state of a run.

    Args:
        path: of the file.
        slam: the filter, with its judgement.
        odometry: the state of `ContinuousOdometry`.
        supervisor: the arrays of `Supervisor`.
        closer: closes loops; None: nobody does.

    Raises:
        StateError: the file cannot be written.
    """
    path = Path(path)
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".part-") as folder:
            state_file.write(slam.state(), Path(folder, FILTER))
            part = Path(folder, "state")
            with zipfile.ZipFile(part, "w") as packed:
                packed.write(Path(folder, FILTER), FILTER)
                packed.writestr(ODOMETRY, json.dumps(odometry))
                packed.writestr(JUDGEMENT, json.dumps(slam.judgement.to_dict()))
                _write_arrays(packed, SUPERVISOR, supervisor)
                if closer is not None:
                    packed.writestr(CLOSER_PARAMETERS, json.dumps(dataclasses.asdict(closer.parameters)))
                    _write_arrays(packed, CLOSER, closer.to_arrays())
            os.replace(part, path)
    except OSError as error:
        raise StateError(f"The state cannot be written to {path}: {error.strerror}.") from None


def _write_arrays(packed: zipfile.ZipFile, name: str, arrays: Mapping[str, np.ndarray]) -> None:
    with packed.open(name, "w") as file:
        np.savez(file, **arrays)


class SavedSession:
    """The parts of a saved run. Each is read when it is asked for."""

    def __init__(self, packed: zipfile.ZipFile, path: str | Path):
        self._packed, self._path = packed, path

    def slam(self, threads: int | None) -> GridSlam:
        """Return the filter with so many threads; None: the saved number. It has no judgement yet."""
        with tempfile.TemporaryDirectory() as folder:
            return state_file.read(Path(self._packed.extract(FILTER, folder)), threads, name=self._path)

    def odometry(self) -> dict:
        """Return the state of `ContinuousOdometry`."""
        return json.loads(self._packed.read(ODOMETRY))

    def judgement(self) -> dict:
        """Return the state of the filter's judgement."""
        return json.loads(self._packed.read(JUDGEMENT))

    def supervisor(self) -> Mapping[str, np.ndarray]:
        """Return the supervisor's arrays, for `Supervisor.from_arrays`."""
        return self._arrays(SUPERVISOR)

    def closer_parameters(self) -> dict | None:
        """Return the loop closer's parameters by name; None: the run had no loop closer."""
        if CLOSER_PARAMETERS not in self._packed.namelist():
            return None
        return json.loads(self._packed.read(CLOSER_PARAMETERS))

    def closer(self) -> Mapping[str, np.ndarray]:
        """Return the loop closer's arrays, for `LoopCloser.from_arrays`."""
        return self._arrays(CLOSER)

    def _arrays(self, name: str) -> Mapping[str, np.ndarray]:
        return np.load(io.BytesIO(self._packed.read(name)), allow_pickle=False)


@contextlib.contextmanager
def opened(path: str | Path) -> Iterator[SavedSession]:
    """Open a saved run; whatever is damaged in it becomes a StateError.

    Raises:
        StateError: the file cannot be read, or holds no state.
    """
    try:
        with zipfile.ZipFile(path) as packed:
            state_file.require_memory(packed)
            yield SavedSession(packed, path)
    except StateError:
        raise
    except (OSError, SlamError, *state_file.DAMAGE) as error:
        raise StateError(f"{path} cannot be read as a saved state: {reason_of(error)}.") from None
