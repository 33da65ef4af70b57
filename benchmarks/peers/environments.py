"""Makes the environment of a peer, .peers/NAME, from the package registry.

Peers need versions of packages that ours exclude. So each has a virtual environment, made once.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import subprocess
import sys
from pathlib import Path
from typing import Iterator, Mapping, Sequence

from benchmarks.peers.catalogue import Peer

FOLDER = ".peers"
INSTALL_S = 1200.0
"""Patience with the registry, wall time."""
PATIENCE = ("--retries", "2", "--timeout", "20")
"""pip's own."""
_STAMP = ".ready"
_NO_ANSWER = (
    "failed to establish a new connection",
    "name resolution",
    "could not resolve",
    "connection refused",
    "connection timed out",
    "read timed out",
    "network is unreachable",
    "proxyerror",
    "max retries exceeded",
)


class PeerError(Exception):
    """A peer cannot be measured; the message is one sentence."""


def make_ready(peer: Peer, folder: Path) -> Path:
    """Install what a peer needs into `folder`/NAME, unless it is there; return its Python.

    Raises:
        PeerError: the registry does not answer, or the installation fails.
    """
    place = folder / peer.name
    python = place / "bin/python"
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / f"{peer.name}.lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # another benchmark may install it at this moment
        stamp, inputs = place / _STAMP, _inputs(peer, place)
        if stamp.exists() and stamp.read_text(encoding="utf-8") == inputs:
            return python
        print(f"installing {peer.name} into {place} ...", file=sys.stderr)
        _run(peer, (sys.executable, "-m", "venv", "--clear", "--without-pip", str(place)))
        pip = (
            sys.executable,
            "-m",
            "pip",
            "--python",
            str(python),
            "--no-input",
            "--disable-pip-version-check",
        )
        what = ("--no-deps", "--prefer-binary", "--requirement", str(peer.requirements))
        _run(peer, (*pip, *PATIENCE, "install", *what))
        stamp.write_text(inputs, encoding="utf-8")
    return python


def own_environment(**variables: str) -> Mapping[str, str]:
    """Return environment variables for a peer's Python: it must not see ROS's packages, nor the user's."""
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME")}
    return {**kept, "PYTHONNOUSERSITE": "1", **variables}


def _inputs(peer: Peer, place: Path) -> str:
    """Digest of what the environment was made from; its path counts, because it cannot be moved."""
    content = peer.requirements.read_bytes() + sys.version.encode() + str(place.resolve()).encode()
    return hashlib.sha256(content).hexdigest()


def _run(peer: Peer, command: Sequence[str]) -> None:
    try:
        done = subprocess.run(
            command,
            env=own_environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            timeout=INSTALL_S,
        )
    except subprocess.TimeoutExpired:
        raise PeerError(f"{peer.name} was not installed within {INSTALL_S / 60.0:.0f} min.") from None
    except OSError as error:
        raise PeerError(f"{peer.name} cannot be installed: {error}.") from None
    if done.returncode == 0:
        return
    if any(sign in done.stdout.lower() for sign in _NO_ANSWER):
        raise PeerError(
            f"{peer.name} is not installed, because the package registry does not answer: check the network "
            "or the proxy, and call again."
        )
    raise PeerError(f"{peer.name} cannot be installed: {_reason(done.stdout.splitlines())}")


def _reason(lines: Sequence[str]) -> str:
    """Return the last error in pip's words, or its last line."""
    said = [line.strip() for line in lines if line.strip()]
    return next(_errors(reversed(said)), said[-1] if said else "pip said nothing") + "."


def _errors(lines: Iterator[str]) -> Iterator[str]:
    return (line.removeprefix("ERROR: ").rstrip(".") for line in lines if line.startswith("ERROR: "))
