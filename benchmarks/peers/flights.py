"""Flies a peer: each flight is a process of its own on the peer's Python, measured after its warm-up."""

from __future__ import annotations

import math
import subprocess
import tempfile
from pathlib import Path

from benchmarks.peers import report
from benchmarks.peers.catalogue import Peer
from benchmarks.peers.environments import PeerError, own_environment
from benchmarks.shared.results import ROOT
from benchmarks.shared.speed import Speed

FLIGHT_S = 300.0
"""Patience with a flight, wall time; compiling is in it."""
SIMULATED_S = 60.0
NEAR_M = 0.3
"""A quadrotor that holds a position ends this near to it. crazyflow's has a lasting error of 0.08 m."""


def fly(peer: Peer, python: Path, simulated_s: float = SIMULATED_S) -> Speed:
    """Fly a peer's quadrotor once.

    Raises:
        PeerError: it did not fly to its end, or its quadrotor did not stay at its goal.
    """
    with tempfile.TemporaryDirectory() as folder:  # MuJoCo leaves files where it runs
        written = Path(folder, "report.json")
        try:
            done = subprocess.run(
                (str(python), "-m", peer.module, str(simulated_s), str(written)),
                cwd=folder,
                env=own_environment(PYTHONPATH=str(ROOT), JAX_PLATFORMS="cpu"),
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=FLIGHT_S,
            )
        except subprocess.TimeoutExpired:
            raise PeerError(f"{peer.name} did not end its flight within {FLIGHT_S:.0f} s.") from None
        except OSError as error:
            raise PeerError(f"{peer.name} cannot be started: {error}.") from None
        if done.returncode != 0:
            raise PeerError(f"{peer.name} does not run: {_last_line(done.stderr, done.returncode)}.")
        try:
            speed, off_m = report.read(written)
        except (OSError, ValueError) as error:
            raise PeerError(f"{peer.name} left no figures: {error}.") from None
    if not (math.isfinite(off_m) and off_m < NEAR_M):
        raise PeerError(f"{peer.name} ended {off_m:.2f} m from its goal, so its speed does not count.")
    return speed


def _last_line(said: str, code: int) -> str:
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    return lines[-1].rstrip(".") if lines else f"it ended with code {code} and said nothing"
