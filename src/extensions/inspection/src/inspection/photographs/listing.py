"""The photographs of a folder: those that count, and those that are left out, each with the reason.

Coverage, findings, grades and the report all read this list, so that none counts what another one could not
read. A photograph is a picture of any name with a JSON of the same name beside it.
"""

from __future__ import annotations

import os
import re
import warnings
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Iterator, NamedTuple

import numpy as np
from PIL import Image, ImageOps

from flight_basics.errors import FlightBasicsError
from input_schemas import read_file
from inspection.camera.survey_camera import SurveyCamera
from inspection.photographs.calibration import read_camera
from inspection.photographs.damage import damage_of
from inspection.photographs.record import PhotographError, PhotographRecord, read_record, stamp_of

SUFFIXES = (".jpg", ".jpeg", ".jpe", ".jfif", ".mpo", ".png", ".tif", ".tiff", ".webp", ".bmp")
"""Of pictures, in small letters; a file may have them in any."""
UNREAD = (
    ".heic", ".heif", ".hif", ".avif", ".jxl", ".jp2", ".j2k", ".jpx", ".gif", ".psd",
    ".tga", ".ppm", ".exr", ".dng", ".gpr", ".raw", ".cr2", ".cr3", ".crw", ".nef", ".nrw", ".arw", ".sr2",
    ".srf", ".srw", ".raf", ".orf", ".rw2", ".pef", ".x3f", ".iiq", ".3fr", ".fff", ".erf", ".mrw", ".kdc",
    ".dcr", ".rwl", ".insp",
)  # fmt: skip
"""Of pictures whose kind is not read here."""
COLOURED = ("RGB", "RGBA", "RGBX", "P", "PA", "CMYK", "YCbCr", "LAB", "HSV")
"""Pillow's names of what has colours, with 8 bits for each."""
AS_STORED = ("RGB", "RGBA", "RGBX", "L")
"""Those whose values are taken as they are."""
SIXTEEN_BITS = ";16"
"""In how Pillow calls pixels with so many bits for each colour."""
JPEGS = ("JPEG", "MPO")
"""Pillow's names of JPEG, and of several in one file, of which the first one counts."""
START_OF_JPEG, START_OF_SCAN, END_OF_JPEG, TAIL_BYTES = b"\xff\xd8", b"\xda", b"\xff\xd9", 4096
ORIENTATION, UPRIGHT, TURNED = 0x0112, 1, range(2, 9)
"""EXIF's tag; its values for a picture that is stored as it is to be seen, and for turned ones.

Some cameras write 0 when they do not know."""
OF_MACOS = "._"
"""Begin of the names of files that hold no picture, whatever they end in."""
NO_POSE = "There is no JSON beside it that tells its pose; place_photographs writes one."
FAST_PX = 64
"""A JPEG is checked in the smallest size, an eighth, in which its decoder gives it."""


class LeftOut(NamedTuple):
    """A photograph that does not count. name: of its file. why: a sentence."""

    name: str
    why: str

    @classmethod
    def of(cls, path: Path, error: Exception) -> LeftOut:
        """Return what an error leaves out; the sentence need not tell the path again."""
        why = str(error)
        for each in (path, path.with_suffix(".json")):
            why = why.removeprefix(f"{each}: ").replace(str(each), each.name)
        return cls(path.name, why[:1].upper() + why[1:])

    @classmethod
    def of_kind(cls, path: Path) -> LeftOut:
        """Return a picture whose kind is not read here."""
        return cls(path.name, f"Its kind, {path.suffix}, is not read here. Export it as JPEG.")


@dataclass(frozen=True)
class Listing:
    """Photographs that count, by name, numbers in their order; and those that are left out."""

    whole: tuple[tuple[Path, PhotographRecord], ...] = ()
    left_out: tuple[LeftOut, ...] = ()

    def tell(self, say: Callable[[str], None]) -> None:
        """Say which are left out, in a sentence each."""
        for each in self.left_out:
            say(f"{each.name}: {each.why} It is left out.")


def listed(folder: Path, pixels: bool = True) -> Listing:
    """Return the photographs of a folder.

    pixels: decode each picture, which takes some 2 ms a megapixel; else only its end is looked at.
    """
    pictures, camera = pictures_in(folder), _camera_of(folder)
    whole, left_out, owners = [], [], dict[str, str]()
    for path in pictures:
        owner = owners.setdefault(path.stem, path.name)
        try:
            if owner != path.name:
                raise PhotographError(f"The JSON beside it belongs to {owner}.")
            if not path.with_suffix(".json").exists():
                raise PhotographError(NO_POSE)
            check_picture(path, pixels, camera)
            whole.append((path, read_record(path.with_suffix(".json"))))
        except FlightBasicsError as error:
            left_out.append(LeftOut.of(path, error))
    for path in unread_in(folder):
        if path.stem not in owners:  # beside a JPEG of its name it is the same photograph
            owners[path.stem] = path.name
            left_out.append(LeftOut.of_kind(path))
    for path in sorted(folder.glob("*.json")):
        if path.stem not in owners and _is_record(path):
            left_out.append(LeftOut(path.name, "There is no photograph beside it."))
    return Listing(tuple(whole), tuple(left_out))


def photographs_in(folder: Path) -> list[Path]:
    """Return the pictures that have a JSON, numbers in their order; some of them may be damaged."""
    return [path for path in pictures_in(folder) if path.with_suffix(".json").exists()]


def records_in(folder: Path) -> tuple[list[tuple[Path, PhotographRecord]], list[str]]:
    """Return the photographs with their records, and a sentence for each that is damaged.

    Pictures are not decoded, so that a UAV in flight need not wait.
    """
    listing = listed(folder, pixels=False)
    said: list[str] = []
    listing.tell(said.append)
    return list(listing.whole), said


def read_photograph(path: Path) -> tuple[np.ndarray, PhotographRecord]:
    """Return a picture, uint8 (height, width, 3), and its record.

    Raises:
        PhotographError: the picture is cut or none, or its JSON is missing or damaged.
    """
    return read_picture(path), read_record(path.with_suffix(".json"))


def read_picture(path: Path, turns: bool = False) -> np.ndarray:
    """Return a picture, uint8 (height, width, 3).

    turns: one that is stored turned is turned upright, as viewers show it. Its calibration would not fit.

    Raises:
        PhotographError: it is cut or none, or it is stored turned.
    """
    try:
        with opened(path) as image:
            _check_as_a_whole(image, path, may_be_turned=turns)
            upright = ImageOps.exif_transpose(image) if turns else image
            return np.array(upright.convert("RGB"))  # one may write to it
    except _DAMAGES as error:
        raise PhotographError(damage_of(path, error)) from None


@contextmanager
def opened(path: Path) -> Iterator[Image.Image]:
    """Give a picture; Pillow warns of none that is merely large, as aerial cameras take them."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Image.DecompressionBombWarning)
        with Image.open(path) as image:
            yield image


def is_converted(path: Path) -> bool:
    """Return whether a picture's colours are not RGB of 8 bits: inks, a palette, 16 bits and others."""
    with opened(path) as image:
        return image.mode not in AS_STORED or any(
            SIXTEEN_BITS in str(tile) for tile in getattr(image, "tile", ())
        )


def size_of(path: Path) -> tuple[int, int]:
    """Return width and height of a picture, px; raises PhotographError if it is none."""
    try:
        with opened(path) as image:
            return image.size
    except _DAMAGES as error:
        raise PhotographError(damage_of(path, error)) from None


def check_picture(path: Path, pixels: bool = True, camera: SurveyCamera | None = None) -> None:
    """Raise PhotographError if a picture is empty, cut, damaged, or of another size. pixels: see `listed`."""
    try:
        with opened(path) as image:
            _check_as_a_whole(image, path)
            if camera is not None and image.size != (camera.width, camera.height):
                raise PhotographError(
                    f"{path}: it has {image.width} x {image.height} px, but calibration.yaml is of "
                    f"{camera.width} x {camera.height} px. Give the original, or its own calibration."
                )
            if pixels or image.format not in JPEGS:
                image.draft("L", (FAST_PX, FAST_PX))
                image.load()
    except _DAMAGES as error:
        raise PhotographError(damage_of(path, error)) from None


_DAMAGES = (OSError, SyntaxError, ValueError, EOFError, Image.DecompressionBombError)
"""What Pillow raises for files that are cut, or no pictures."""


def _check_as_a_whole(image: Image.Image, path: Path, may_be_turned: bool = False) -> None:
    """Raise an error if a JPEG has no end, or if a picture has no colours or is stored turned.

    Nobody tells how the calibration of a turned picture is meant. Rust is known by its colour. What has 16
    bits in one channel would become white.
    """
    if image.format in JPEGS and not _has_end(path):
        raise EOFError("it has no end")
    if image.mode not in COLOURED:
        raise PhotographError(
            f"{path}: it has no colours, by which rust is known ({image.mode}). Give the photograph in "
            "colour, with 8 bits for each."
        )
    turned = image.getexif().get(ORIENTATION, UPRIGHT)
    if turned in TURNED and not may_be_turned:
        raise PhotographError(
            f"{path}: its EXIF tells that it is stored turned (orientation {turned}). Store it upright, or "
            "delete the tag if the calibration is of the picture as it is stored."
        )


def _has_end(path: Path) -> bool:
    """Return whether a JPEG has its end.

    Entropy-coded data never look like one. Decoders take a file that ends in zeros, as a loss of power leaves
    it, for a grey picture. Some cameras put more behind the end.
    """
    with path.open("rb") as stream:
        stream.seek(-min(TAIL_BYTES, path.stat().st_size), os.SEEK_END)
        if END_OF_JPEG in stream.read():
            return True
    content, place = path.read_bytes(), len(START_OF_JPEG)
    while content[place + 1 : place + 2] not in (START_OF_SCAN, b""):  # a thumbnail has an end of its own
        place += 2 + int.from_bytes(content[place + 2 : place + 4], "big")
    return content.find(END_OF_JPEG, place) >= 0


def _camera_of(folder: Path) -> SurveyCamera | None:
    """Return the camera of a folder; None: it has none that can be read, which its readers tell."""
    try:
        return read_camera(folder / "calibration.yaml")
    except PhotographError:
        return None


def pictures_in(folder: Path) -> list[Path]:
    """Return the pictures of a folder, numbers in their order, with a JSON or without."""
    if not folder.is_dir():
        return []
    return sorted((path for path in _files_of(folder) if path.suffix.lower() in SUFFIXES), key=_order)


def unread_in(folder: Path) -> list[Path]:
    """Return the pictures of a folder whose kind is not read here."""
    if not folder.is_dir():
        return []
    return sorted((path for path in _files_of(folder) if path.suffix.lower() in UNREAD), key=_order)


def _files_of(folder: Path) -> list[Path]:
    """Return what is in a folder, without what macOS puts beside each file on a disk of others."""
    return [path for path in folder.iterdir() if not path.name.startswith(OF_MACOS)]


def _order(path: Path) -> tuple:
    """Return what sorts file names: stamps by their value, others as one counts (DJI_9 before DJI_10)."""
    stamp_s = stamp_of(path)
    if stamp_s is not None:
        return 0, stamp_s, (), path.name
    words = re.split(r"(\d+)", path.stem)
    return 1, 0.0, tuple((int(w), "") if w.isdecimal() else (0, w) for w in words), path.name


@dataclass(frozen=True)
class Placed:
    """What makes a JSON a photograph's."""

    position_m: Any


def _is_record(path: Path) -> bool:
    """Return whether a JSON tells a pose, as a photograph's does."""
    try:
        read_file(path, "The record", Placed, PhotographError, other_keys=True)
    except PhotographError:
        return False
    return True
