"""The peers that the package registry has."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

_HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Peer:
    """A simulator beside ours.

    flies: what its flight is, for the table. requirements: its packages. module: the flight, which is called
    with the simulated time in s and the file for its `report`.
    """

    name: str
    flies: str
    requirements: Path
    module: str


PEERS = {
    peer.name: peer
    for peer in (
        Peer(
            "pyflyt",
            "PyFlyt 0.29: QuadX holds a position, PyBullet at 240 Hz, no lidar",
            _HERE / "pyflyt.txt",
            "benchmarks.peers.pyflyt_flight",
        ),
        Peer(
            "crazyflow",
            "crazyflow 0.4: Crazyflie holds a position, JAX on the CPU at 500 Hz, no lidar",
            _HERE / "crazyflow.txt",
            "benchmarks.peers.crazyflow_flight",
        ),
    )
}
