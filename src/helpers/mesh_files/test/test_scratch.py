"""Folders that go with their process."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from mesh_files.scratch import scratch_folder

KILLED = """
import os, signal
from mesh_files.scratch import scratch_folder
folder = scratch_folder("meshes")
open(folder.name + "/0.obj", "w").close()
os.kill(os.getpid(), signal.SIGTERM)
"""


def test_what_a_killed_process_left_goes_when_the_next_one_needs_a_folder(tmp_path, monkeypatch):
    subprocess.run([sys.executable, "-c", KILLED], env={**os.environ, "TMPDIR": str(tmp_path)}, check=False)
    (left,) = tmp_path.iterdir()
    others = [tmp_path / f"meshes_of_process_{os.getppid()}_a", tmp_path / "meshes_of_process_x_a"]
    for folder in others:
        folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with scratch_folder("other"):
        assert left.exists()
    with scratch_folder("meshes") as folder:
        assert f"meshes_of_process_{os.getpid()}_" in folder
        assert sorted(tmp_path.iterdir()) == sorted([Path(folder), *others])
    assert sorted(tmp_path.iterdir()) == sorted(others)
