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
    """What another container's process of the same number left stays: that process may run."""
    subprocess.run([sys.executable, "-c", KILLED], env={**os.environ, "TMPDIR": str(tmp_path)}, check=False)
    (left,) = tmp_path.iterdir()
    dead, _, namespace = left.name.removeprefix("meshes_of_process_").split("_")[:3]
    names = [f"{os.getppid()}_in_{namespace}_a", f"x_in_{namespace}_a", f"{dead}_in_{int(namespace) + 1}_a"]
    others = [tmp_path / f"meshes_of_process_{name}" for name in names]
    for folder in others:
        folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with scratch_folder("other"):
        assert left.exists()
    with scratch_folder("meshes") as folder:
        assert f"meshes_of_process_{os.getpid()}_" in folder
        assert sorted(tmp_path.iterdir()) == sorted([Path(folder), *others])
    assert sorted(tmp_path.iterdir()) == sorted(others)
