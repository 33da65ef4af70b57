"""Candidates that are kept beside their photographs: by us, so that a search is not done twice, or by others.

Those of another detector are in STAMP.marks.json: `detector`, its name, and `candidates`, each with `kind`,
`size_px`, the number of all its pixels, and `pixels`, some of them, [x, y] in px. If it has `photograph`, the
SHA-256 of the JPEG, the marks do not count for another photograph that has got this name since.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import math
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Sequence
from zipfile import BadZipFile

import numpy as np

from input_schemas import read_file
from inspection.files.whole import write_whole
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import Candidate
from inspection.photographs.record import PhotographError

SUFFIX = ".candidates.npz"
MARKS = ".marks.json"


@dataclass(frozen=True)
class MarkEntry:
    """A candidate in a file of marks; see the module. Raises ValueError as `marked`."""

    kind: str
    pixels: tuple[tuple[float, float], ...]
    size_px: int

    def __post_init__(self) -> None:
        _ = self.candidate

    @property
    def candidate(self) -> Candidate:
        """What was marked."""
        return marked(self.kind, np.reshape(self.pixels, (-1, 2)), self.size_px)


@dataclass(frozen=True)
class MarksFile:
    """The marks of another detector; see the module."""

    candidates: tuple[MarkEntry, ...]
    photograph: str | None = None


def read_marks(photograph: Path) -> list[Candidate] | None:
    """Return what another detector has marked in this photograph; None: none has looked at it.

    Raises:
        PhotographError: the file of marks is damaged.
    """
    path = photograph.with_suffix(MARKS)
    if not path.exists():
        return None
    told = read_file(path, "The marks", MarksFile, PhotographError, other_keys=True)
    if told.photograph is not None and told.photograph != _digest_of(photograph):
        return None
    return [each.candidate for each in told.candidates]


def write_marks(photograph: Path, found: Sequence[Candidate], detector: str) -> None:
    """Keep what a detector has marked in a photograph.

    Raises:
        PhotographError: it cannot be written; the disk may be full.
    """
    path = photograph.with_suffix(MARKS)
    marks = [
        {"kind": each.kind, "size_px": each.size_px, "pixels": np.round(each.pixels, 2).tolist()}
        for each in found
    ]
    try:
        content = {"detector": detector, "photograph": _digest_of(photograph), "candidates": marks}
        write_whole({path: json.dumps(content).encode()})
    except OSError as error:
        raise PhotographError(f"{path} cannot be written: {error.strerror}.") from None


def is_searched(photograph: Path) -> bool:
    """Return whether the candidates in a photograph are kept beside it, by us or by another detector."""
    return any(photograph.with_suffix(suffix).exists() for suffix in (SUFFIX, MARKS))


def _digest_of(photograph: Path) -> str:
    return hashlib.sha256(photograph.read_bytes()).hexdigest()


def marked(kind: str, pixels: np.ndarray, size_px: int) -> Candidate:
    """Return a candidate of another detector. Raises ValueError, with a sentence, if it makes no sense."""
    if not kind:
        raise ValueError("a candidate has no kind")
    if pixels.ndim != 2 or pixels.shape[1:] != (2,) or not len(pixels) or not np.isfinite(pixels).all():
        raise ValueError(f"the {kind} needs the places of its pixels, x and y, in finite numbers")
    if not math.isfinite(size_px) or size_px < len(pixels):
        raise ValueError(f"the {kind} has {len(pixels)} pixels, but its size is {size_px}")
    return Candidate(kind, pixels.astype(float), int(size_px))


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

    def read(self, path: Path) -> tuple[list[Candidate], tuple[str, ...]] | None:
        """Return the candidates of a photograph, and its flaws; None: it was not searched."""
        try:
            with np.load(path.with_suffix(SUFFIX)) as stored:
                if str(stored["key"]) != self._key_of(path):
                    return None
                ends = np.cumsum(stored["counts"])[:-1]
                parts = np.split(stored["pixels"], ends) if len(stored["counts"]) else []
                rows = zip(stored["kinds"], parts, stored["sizes"])
                found = [Candidate(str(kind), pixels, int(size)) for kind, pixels, size in rows]
                return found, tuple(map(str, stored["flaws"]))
        except (OSError, ValueError, KeyError, EOFError, BadZipFile):
            return None

    def write(self, path: Path, found: Sequence[Candidate], flaws: Sequence[str] = ()) -> None:
        """Keep the candidates of a photograph, and its flaws."""
        pixels = [each.pixels for each in found] or [np.zeros((0, 2))]
        content = io.BytesIO()
        with contextlib.suppress(OSError):
            np.savez(
                content,
                key=self._key_of(path),
                kinds=np.array([each.kind for each in found], str),
                sizes=np.array([each.size_px for each in found], np.int64),
                counts=np.array([len(each.pixels) for each in found], np.int64),
                pixels=np.concatenate(pixels),
                flaws=np.array(flaws, str),
            )
            write_whole({path.with_suffix(SUFFIX): content.getvalue()})

    def _key_of(self, path: Path) -> str:
        key = self._key.copy()
        key.update(path.read_bytes() + path.with_suffix(".json").read_bytes())
        key.update((path.parent / "calibration.yaml").read_bytes())
        return key.hexdigest()


@cache
def _program() -> bytes:
    """Return a digest of this package's sources: another program may find other candidates."""
    sources = sorted(Path(__file__).parent.rglob("*.py"))
    return hashlib.sha256(b"".join(each.read_bytes() for each in sources)).digest()
