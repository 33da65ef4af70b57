"""A workspace that was built before its packages moved is built anew: catkin deletes nothing that it made."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("moved", [False, True])
def test_a_build_counts_only_while_its_packages_are_in_their_folders(tmp_path, moved):
    places = [tmp_path / "src/one", tmp_path / "src/two words"]
    lines = [f"{place.name[:3]}_SOURCE_DIR:STATIC={place}\n" for place in places]
    (tmp_path / "build").mkdir()
    (tmp_path / "build/CMakeCache.txt").write_text("OTHER:STRING=/nowhere\n" + "".join(lines))
    for place in places:
        (place / "__pycache__").mkdir(parents=True)  # Python's cache stays where a package was
    for place in places[: 1 if moved else 2]:
        (place / "CMakeLists.txt").touch()
    script = f"root=. log_file=log; source '{ROOT}/scripts/setup.sh'; cd '{tmp_path}'; all_sources_exist"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (int(moved), "")


def test_a_program_whose_script_is_in_another_package_now_is_removed(tmp_path):
    programs = tmp_path / "devel/lib/one"
    programs.mkdir(parents=True)
    (tmp_path / "stays").touch()
    for name in ("stays", "moved"):
        (programs / name).write_text(f"#!/python\npython_script = '{tmp_path / name}'\n")
    (programs / "own").write_text("#!/bin/sh\n")
    script = f"root=. log_file=log; source '{ROOT}/scripts/setup.sh'; cd '{tmp_path}'; set -e; remove_relays"
    subprocess.run(["bash", "-c", script], check=True)
    assert sorted(path.name for path in programs.iterdir()) == ["own", "stays"]
