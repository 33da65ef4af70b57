"""A file is replaced at once, whatever it is."""

from __future__ import annotations

import multiprocessing
import os
import signal
import stat

import numpy as np
import pytest

from gridslam.evaluation import read_tum, write_tum
from gridslam.files import replacing
from gridslam.files.replacing import replace_file
from gridslam.trajectory import Trajectory


def test_a_kill_while_a_trajectory_is_written_leaves_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "path.tum"
    old, new = (Trajectory(np.arange(3.0), np.full((3, 3), value)) for value in (1.0, 2.0))
    write_tum(path, old)
    # When the process is killed after the first bytes have gone to the disk
    monkeypatch.setattr(replacing.os, "fsync", lambda _: os.kill(os.getpid(), signal.SIGKILL))
    child = multiprocessing.get_context("fork").Process(target=write_tum, args=(path, new))
    child.start()
    child.join()
    assert child.exitcode == -signal.SIGKILL
    # Then the old one is there, and the next one replaces it
    np.testing.assert_allclose(read_tum(path).poses_in_map, old.poses_in_map, rtol=1e-8)
    monkeypatch.undo()
    write_tum(path, new)
    np.testing.assert_allclose(read_tum(path).poses_in_map, new.poses_in_map, rtol=1e-8)


def test_a_link_stays_a_link_and_the_umask_counts(tmp_path):
    (tmp_path / "link").symlink_to("file")
    before = os.umask(0o027)
    try:
        replace_file(tmp_path / "link", "new")
    finally:
        os.umask(before)
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_text() == "new"
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o640


def test_what_is_no_file_is_written_as_it_is(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    replace_file(pipe, "figures")
    assert os.read(reader, 100) == b"figures"
    os.close(reader)
    assert stat.S_ISFIFO(pipe.stat().st_mode)


@pytest.mark.table("name", ["no/folder/file", "."])
def test_what_cannot_be_written_is_named(tmp_path, name):
    with pytest.raises(OSError, match=r"No such file|directory") as caught:
        replace_file(tmp_path / name, "text")
    assert caught.value.filename == str(tmp_path / name)
    assert list(tmp_path.iterdir()) == []
