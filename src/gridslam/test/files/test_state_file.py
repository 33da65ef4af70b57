"""A saved state that is damaged, or of someone else's making, is refused and breaks nothing."""

from __future__ import annotations

import contextlib
import dataclasses
import math

import numpy as np
import pytest
import rooms
from hypothesis import given
from hypothesis import strategies as st

from gridslam import GridSlam, StateError
from gridslam.files import state_file


@pytest.fixture(scope="module")
def saved_file(tmp_path_factory):
    """A state in the middle of a run."""
    log = rooms.log()
    slam = GridSlam(
        dataclasses.replace(rooms.PARAMETERS, particles=4), None, log.truth.poses_in_map[0], keep_scans=True
    )
    rooms.run(slam, log, 0, 30)
    path = tmp_path_factory.mktemp("saved") / "state"
    state_file.write(slam.state(), path)
    return path


def read(path):
    return state_file.read(path, GridSlam.from_state)


def changed(state, names, change):
    """A state with one field of a field, or of itself, changed."""
    first, _, rest = names.partition(".")
    value = getattr(state, first)
    return _Changed(state, first, changed(value, rest, change) if rest else change(value))


class _Changed:
    """A dataclass with another value, which is not checked."""

    def __new__(cls, state, name, value):
        other = object.__new__(type(state))
        for field in dataclasses.fields(state):
            object.__setattr__(other, field.name, getattr(state, field.name))
        object.__setattr__(other, name, value)
        return other


def with_last(value):
    def change(array):
        array = array.copy()
        array.flat[-1] = value
        return array

    return change


@pytest.mark.table(
    ("names", "change"),
    [
        *((name, with_last(10**6)) for name in ("maps.tables", "maps.tiles.ends")),
        *((name, with_last(10**6)) for name in ("tree.leaves", "tree.node_parents")),
        *((name, with_last(-5)) for name in ("maps.tables", "maps.tiles.ends")),
        *((name, with_last(-5)) for name in ("tree.leaves", "tree.node_parents")),
        ("maps.tables", lambda array: array[:-1]),
        ("maps.tables", lambda array: array[:, :0]),
        ("maps.tables", lambda array: array.astype(float)),
        ("maps.corner", lambda array: array[:1]),
        ("maps.corner", with_last(2**62)),
        ("maps.tiles.visits", lambda array: array[:-1]),
        ("maps.tiles.occupied", lambda array: array[:, :-1]),
        ("maps.tiles.means", lambda array: array[..., :1]),
        ("maps.tiles.hits", lambda array: array.astype(float)),
        ("pieces.first_in_map", lambda number: number + 1),
        ("pieces.left_out", lambda ranges: (*ranges, (3, 10**6))),
        ("tree.node_poses", with_last(math.nan)),
        ("tree.node_poses", lambda array: array[:-1]),
        ("tree.stamps_s", lambda array: array[:-1]),
        ("poses", lambda array: array[:-1]),
        ("poses", with_last(math.inf)),
        ("log_weights", lambda array: array[:, None]),
        ("motion.now", lambda array: array[:-1]),
        ("motion.tried", with_last(math.nan)),
        ("motion.covariance", lambda none: np.full((3, 3), math.nan)),
        ("scans", lambda scans: scans[:-1]),
        ("scans", lambda scans: [*scans[:-1], "a scan"]),
        ("odometry", lambda array: array[:-1]),
        ("parameters", lambda parameters: {"particles": 4}),
    ],
)
def test_a_state_that_points_at_what_is_not_there_is_refused_in_a_sentence(
    saved_file, tmp_path, names, change
):
    state = state_file.read(saved_file, lambda state: state)
    state_file.write(changed(state, names, change), tmp_path / "changed")
    with pytest.raises(StateError, match="cannot be read as a saved state"):
        read(tmp_path / "changed")


def test_a_state_of_more_particles_than_it_holds_takes_no_memory_for_them(saved_file, tmp_path):
    state = state_file.read(saved_file, lambda state: state)
    many = dataclasses.replace(state.parameters, particles=9999)
    state_file.write(changed(state, "parameters", lambda parameters: many), tmp_path / "many")
    with pytest.raises(StateError, match="poses do not fit 9999 particles"):
        read(tmp_path / "many")


def arrays_of(path):
    with np.load(path) as file:
        return {name: file[name] for name in file.files}


def test_a_state_larger_than_the_memory_is_not_unpacked(saved_file, tmp_path, monkeypatch):
    np.savez_compressed(tmp_path / "bomb.npz", **arrays_of(saved_file), more=np.zeros(10**6))
    monkeypatch.setattr(state_file, "memory_bytes", lambda: 7 * 10**6)
    with pytest.raises(StateError, match=r"more than this machine's 0\.0 GB"):
        read(tmp_path / "bomb.npz")


def test_a_state_with_pickled_objects_is_refused(saved_file, tmp_path):
    pickled = {**arrays_of(saved_file), "float64": np.array([print], dtype=object)}
    np.savez(tmp_path / "pickled.npz", **pickled)
    with pytest.raises(StateError, match="pickle"):
        read(tmp_path / "pickled.npz")


@given(st.data())
def test_no_damaged_byte_of_a_state_gets_further_than_a_sentence(saved_file, tmp_path_factory, data):
    content = bytearray(saved_file.read_bytes())
    where = data.draw(st.integers(0, len(content) - 1))
    content[where : where + data.draw(st.integers(1, 40))] = data.draw(st.binary(min_size=1, max_size=40))
    path = tmp_path_factory.mktemp("damaged") / "state"
    path.write_bytes(content)
    with contextlib.suppress(StateError):
        read(path)
