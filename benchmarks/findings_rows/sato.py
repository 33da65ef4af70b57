"""The baseline: scikit-image's `sato`, on a Python of its own."""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple, Sequence

import numpy as np
from PIL import Image

from benchmarks.peers.catalogue import Peer
from benchmarks.peers.environments import FOLDER, PeerError, make_ready, own_environment
from benchmarks.shared.results import ROOT

PEERS = ROOT / "benchmarks/peers"
SATO = Peer("scikit-image", "sato with hysteresis, untuned", PEERS / "scikit-image.txt", "sato_lines")
RUN_S = 3600.0
"""Patience with all pictures, wall time."""


class Lines(NamedTuple):
    """What the baseline marks. masks: bool (height, width) of each picture. cpu_s: of each."""

    masks: list[np.ndarray]
    cpu_s: list[float]
    peak_mb: float


def lines_by_sato(pictures: Sequence[Path]) -> Lines:
    """Return the lines that `sato` finds; it is installed at the first call.

    Raises:
        PeerError: it cannot be installed, or does not run.
    """
    python = make_ready(SATO, ROOT / FOLDER)
    with tempfile.TemporaryDirectory() as folder:
        listed = Path(folder, "pictures.json")
        listed.write_text(json.dumps([str(path.resolve()) for path in pictures]), encoding="utf-8")
        command = (str(python), str(PEERS / f"{SATO.module}.py"), str(listed), folder)
        try:
            done = subprocess.run(
                command,
                env=own_environment(),
                capture_output=True,
                text=True,
                errors="replace",
                timeout=RUN_S,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise PeerError(f"sato does not run: {error}.") from None
        if done.returncode != 0:
            said = done.stderr.strip().splitlines() or [f"code {done.returncode}"]
            raise PeerError(f"sato does not run: {said[-1]}.")
        report = json.loads(Path(folder, "report.json").read_text(encoding="utf-8"))
        masks = []
        for number in range(len(pictures)):
            with Image.open(Path(folder, f"{number}.png")) as image:
                masks.append(np.asarray(image) > 0)
    return Lines(masks, report["cpu_s"], report["peak_mb"])
