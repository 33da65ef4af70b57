"""Peers that fly by turns with ours. One that fails has a sentence in place of figures, and flies no more."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import Any, Callable, Mapping, Sequence

from benchmarks.peers.catalogue import PEERS
from benchmarks.peers.environments import FOLDER, PeerError, make_ready
from benchmarks.peers.flights import fly as fly_peer
from benchmarks.peers.programs import PROGRAMS
from benchmarks.shared.results import ROOT
from benchmarks.shared.speed import Speed, medians

HINT = (
    f"No other simulator flew beside ours; ask for them: --peers {' '.join(PEERS)} "
    f"{' '.join(f'--{name} PATH' for name in PROGRAMS)}."
)


class Turns:
    """The peers of one run of a benchmark.

    left_out: why a peer has no figures, by its name.
    """

    def __init__(self, names: Sequence[str], folder: Path, programs: Mapping[str, Path]) -> None:
        """Install what is missing.

        names: of `PEERS`. folder: of their environments. programs: what this machine has of `PROGRAMS`.
        """
        self.left_out: dict[str, str] = {}
        self._speeds: dict[str, list[Speed]] = {}
        self._fly: dict[str, Callable[[], Speed]] = {}
        for name in names:
            try:
                self._fly[name] = partial(fly_peer, PEERS[name], make_ready(PEERS[name], folder))
            except PeerError as error:
                self.left_out[name] = str(error)
        for name, path in programs.items():
            self._fly[name] = partial(PROGRAMS[name].fly, path)
        self._names = (*names, *programs)

    def fly(self) -> None:
        """Fly each peer once."""
        for name, fly in self._fly.items():
            if name not in self.left_out:
                try:
                    self._speeds.setdefault(name, []).append(fly())
                except PeerError as error:
                    self.left_out[name] = str(error)

    def figures(self) -> dict[str, dict[str, Any]]:
        """Return the medians of each peer, as `medians`; of one that failed only `left_out`."""
        return {
            name: {"left_out": self.left_out[name]} if name in self.left_out else medians(self._speeds[name])
            for name in self._names
        }


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say which peers fly."""
    parser.add_argument(
        "--peers",
        nargs="+",
        default=(),
        choices=tuple(PEERS),
        help="simulators of the package registry to fly beside ours",
    )
    for name, program in PROGRAMS.items():
        parser.add_argument(
            f"--{name}", type=Path, metavar="PATH", help=f"fly it beside ours: {program.path}"
        )


def programs_of(given: argparse.Namespace) -> dict[str, Path]:
    """Return the paths of programs that the caller gave, by their names."""
    paths = {name: getattr(given, name) for name in PROGRAMS}
    return {name: path.absolute() for name, path in paths.items() if path is not None}


def turns_of(given: argparse.Namespace) -> Turns:
    """Return the peers that the caller asked for, installed."""
    return Turns(given.peers, ROOT / FOLDER, programs_of(given))


def flies(name: str) -> str:
    """Return what a peer flies, for a table."""
    return PEERS[name].flies if name in PEERS else PROGRAMS[name].flies


def sentences(peers: Mapping[str, Mapping[str, Any]]) -> tuple[str, ...]:
    """Return a sentence for each peer that failed, for below a table."""
    return tuple(f"Left out: {found['left_out']}" for found in peers.values() if "left_out" in found)
