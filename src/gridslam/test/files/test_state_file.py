"""A saved state that is damaged, or of someone else's making, is refused and breaks nothing."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import math

import numpy as np
import pytest
import rooms
from hypothesis import given, settings
from hypothesis import strategies as st

from gridslam import GridSlam, StateError
from gridslam.files import state_file


@pytest.fixture(scope="module")
def saved_file(tmp_path_factory):
    """The bytes of a state in the middle of a run."""
    log = rooms.log()
    slam = GridSlam(
        dataclasses.replace(rooms.PARAMETERS, particles=4), None, log.truth.poses_in_map[0], keep_scans=True
    )
    rooms.run(slam, log, 0, 30)
    path = tmp_path_factory.mktemp("saved") / "state"
    state_file.write(slam.state(), path)
    return path.read_bytes()


@pytest.fixture(scope="module")
def saved(saved_file):
    """The same as arrays."""
    with np.load(io.BytesIO(saved_file)) as file:
        return {name: file[name] for name in file.files}


def changed(arrays, name, change):
    """The arrays of a state with one of them changed."""
    array = arrays[name].copy()
    return {**arrays, name: change(array)}


def with_last(value):
    def change(array):
        array.flat[-1] = value
        return array

    return change


@pytest.mark.parametrize(
    ("name", "change"),
    [
        *((name, with_last(10**6)) for name in ("map_tables", "tile_ends", "leaves", "node_parents")),
        *((name, with_last(-5)) for name in ("map_tables", "tile_ends", "leaves", "node_parents")),
        ("map_tables", lambda array: array[:-1]),
        ("map_tables", lambda array: array[:, :0]),
        ("map_tables", lambda array: array.astype(float)),
        ("map_corner", lambda array: array[:1]),
        ("map_corner", with_last(2**62)),
        ("tile_visits", lambda array: array[:-1]),
        ("tile_occupied", lambda array: array[:, :-1]),
        ("end_means", lambda array: array[..., :1]),
        ("end_hits", lambda array: array.astype(float)),
        ("node_poses", with_last(math.nan)),
        ("node_poses", lambda array: array[:-1]),
        ("stamps_s", lambda array: array[:-1]),
        ("poses", lambda array: array[:-1]),
        ("poses", with_last(math.inf)),
        ("log_weights", lambda array: array[:, None]),
        ("motion", lambda array: array[:-2]),
        ("scan_beams", with_last(10**6)),
        ("scan_beams", with_last(-1)),
        ("scan_rest", lambda array: array[:-1]),
    ],
)
def test_a_state_that_points_at_what_is_not_there_is_refused_in_a_sentence(saved, tmp_path, name, change):
    np.savez(tmp_path / "changed.npz", **changed(saved, name, change))
    with pytest.raises(StateError, match="holds no complete state of gridslam"):
        state_file.read(tmp_path / "changed.npz")


def test_a_state_of_more_particles_than_it_holds_takes_no_memory_for_them(saved, tmp_path):
    header = json.loads(str(saved["header"]))
    header["parameters"]["particles"] = 9999
    np.savez(tmp_path / "many.npz", **{**saved, "header": np.array(json.dumps(header))})
    with pytest.raises(StateError, match="poses do not fit 9999 particles"):
        state_file.read(tmp_path / "many.npz")


def test_a_state_larger_than_the_memory_is_not_unpacked(saved, tmp_path, monkeypatch):
    np.savez_compressed(tmp_path / "bomb.npz", **{**saved, "more": np.zeros(10**6)})
    monkeypatch.setattr(state_file, "memory_bytes", lambda: 7 * 10**6)
    with pytest.raises(StateError, match=r"more than this machine's 0\.0 GB"):
        state_file.read(tmp_path / "bomb.npz")


def test_a_state_with_pickled_objects_is_refused(saved, tmp_path):
    np.savez(tmp_path / "pickled.npz", **{**saved, "poses": np.array([print], dtype=object)})
    with pytest.raises(StateError, match="pickle"):
        state_file.read(tmp_path / "pickled.npz")


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_no_damaged_byte_of_a_state_gets_further_than_a_sentence(saved_file, tmp_path_factory, data):
    content = bytearray(saved_file)
    where = data.draw(st.integers(0, len(content) - 1))
    content[where : where + data.draw(st.integers(1, 40))] = data.draw(st.binary(min_size=1, max_size=40))
    path = tmp_path_factory.mktemp("damaged") / "state"
    path.write_bytes(content)
    with contextlib.suppress(StateError):
        state_file.read(path)
