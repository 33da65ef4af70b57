"""Candidates of photographs that were searched before: a search that begins again is over at once."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Sequence
from zipfile import BadZipFile

import numpy as np

from inspection_tools.findings.candidates import Candidate
from inspection_tools.findings.parameters import FindingParameters

SUFFIX = ".candidates.npz"


class Remembered:
    """Keeps the candidates of each photograph in a file beside it.

    It counts only for the same photograph, pose, mesh, parameters and program. A folder that cannot be
    written to remembers nothing.

    Args:
        triangles_m: (m, 3, 3) of the mesh.
    """

    def __init__(self, triangles_m: np.ndarray, parameters: FindingParameters) -> None:
        self._key = hashlib.sha256(np.ascontiguousarray(triangles_m).tobytes())
        self._key.update(json.dumps(asdict(parameters)).encode() + _program())

    def read(self, path: Path) -> list[Candidate] | None:
        """Return the candidates of a photograph; None: it was not searched."""
        try:
            with np.load(path.with_suffix(SUFFIX)) as stored:
                if str(stored["key"]) != self._key_of(path):
                    return None
                ends = np.cumsum(stored["counts"])[:-1]
                parts = np.split(stored["pixels"], ends) if len(stored["counts"]) else []
                rows = zip(stored["kinds"], parts, stored["sizes"])
                return [Candidate(str(kind), pixels, int(size)) for kind, pixels, size in rows]
        except (OSError, ValueError, KeyError, EOFError, BadZipFile):
            return None

    def write(self, path: Path, found: Sequence[Candidate]) -> None:
        """Keep the candidates of a photograph."""
        partial = path.with_suffix(SUFFIX + ".part")
        pixels = [each.pixels for each in found] or [np.zeros((0, 2))]
        try:
            with partial.open("wb") as stream:
                np.savez(
                    stream,
                    key=self._key_of(path),
                    kinds=np.array([each.kind for each in found], str),
                    sizes=np.array([each.size_px for each in found], np.int64),
                    counts=np.array([len(each.pixels) for each in found], np.int64),
                    pixels=np.concatenate(pixels),
                )
            os.replace(partial, path.with_suffix(SUFFIX))
        except OSError:
            return

    def _key_of(self, path: Path) -> str:
        key = self._key.copy()
        key.update(path.read_bytes() + path.with_suffix(".json").read_bytes())
        key.update((path.parent / "calibration.yaml").read_bytes())
        return key.hexdigest()


@cache
def _program() -> bytes:
    """Return a digest of this package's sources: another program may find other candidates."""
    sources = sorted(Path(__file__).parent.glob("*.py"))
    return hashlib.sha256(b"".join(each.read_bytes() for each in sources)).digest()
