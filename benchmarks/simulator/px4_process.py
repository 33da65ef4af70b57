"""The program of real PX4 SITL, started for a benchmark."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Mapping

PROGRAM = "bin/px4"
LEAVES_S = 10.0


def start_px4(
    build: Path, instance: int, folder: Path, parameters: Mapping[str, float], model: str = "iris"
) -> subprocess.Popen[bytes]:
    """Start PX4, which then looks for the simulator.

    build: PX4's build/px4_sitl_default. instance: its option -i, from which its ports follow. folder: an
    empty one, where it keeps its files and its log. model: PX4_SIM_MODEL.
    """
    # PX4's start script reads this file, because its folder comes first.
    (folder / "px4-rc.params").write_text("".join(f"param set {k} {v}\n" for k, v in parameters.items()))
    path = f"{folder}:{build / 'bin'}:{os.environ['PATH']}"
    with open(folder / "px4.log", "w", encoding="utf-8") as log:
        return subprocess.Popen(
            [build / PROGRAM, "-i", str(instance), "-d", build / "etc", "-s", "etc/init.d-posix/rcS"],
            cwd=folder,
            env={**os.environ, "PATH": path, "PX4_SIM_MODEL": model},
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
        )


def end_px4(process: subprocess.Popen[bytes]) -> None:
    """End PX4, and wait until it is gone."""
    process.terminate()
    process.wait(LEAVES_S)
