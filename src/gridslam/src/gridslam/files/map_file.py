"""Maps as files: an image and a YAML file about it, as ROS's map_server, map_saver and amcl have them."""

from __future__ import annotations

import io
import math
import re
import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gridslam.errors import MapError, reason_of
from gridslam.files.replacing import replace_file, replace_files
from gridslam.occupancy_grid import CELLS_MAX, FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from input_schemas import read_made

if TYPE_CHECKING:
    from PIL.Image import Image as PillowImage

FREE_AT_MOST, OCCUPIED_AT_LEAST = 25, 65
"""map_saver's limits of occupancy."""
GREY_FREE, GREY_UNKNOWN, GREY_OCCUPIED = 254, 205, 0
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
"""As map_saver writes them. Between them a cell is unknown; the grey of unknown is just above the second."""
_PILLOW_LIMIT = threading.Lock()
"""Locked while Pillow's limit of an image's size is off."""
MODES = ("trinary", "scale", "raw")
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?")
"""A number to map_server that may be a text to PyYAML: '0.05' in quotes, or 5e-2 without a point."""
QUOTED_OR_TAB = re.compile(r"""#[^\n]*|"(?:[^"\\\n]|\\.)*"|'[^'\n]*'|\t""")
"""A comment, a text in quotes, or a tab."""
YAW_MAX_RAD = 1e-6
"""A smaller turn moves no cell: at 10,000 cells from the corner by 0.01 of a cell."""
WIDE_FORMATS = ("PNG", "PPM")
"""Formats whose wide pixels have 16 bits. Those of a TIFF may have 32."""


@dataclass(frozen=True)
class Thresholds:
    """How occupancies in percent are divided into free, unknown and occupied.

    Raises MapError when they make no sense.
    """

    free_at_most: int = FREE_AT_MOST
    occupied_at_least: int = OCCUPIED_AT_LEAST

    def __post_init__(self) -> None:
        if not 0 <= self.free_at_most < self.occupied_at_least <= 100:
            raise MapError(
                "The thresholds of free and occupied cells must rise within 0 to 100, but they are "
                f"{self.free_at_most} and {self.occupied_at_least}."
            )


ROWS_AT_ONCE = 64
"""Of a map that becomes a picture: all at once would take memory for several pictures."""


def greys_of(grid: OccupancyGrid, thresholds: Thresholds = Thresholds()) -> np.ndarray:
    """Return the picture of a map, (h, w) uint8: white free, black occupied, grey unknown, row 0 on top."""
    greys = np.full(grid.cells.shape, GREY_UNKNOWN, dtype=np.uint8)
    for first in range(0, len(greys), ROWS_AT_ONCE):
        cells, part = grid.cells[::-1][first : first + ROWS_AT_ONCE], greys[first : first + ROWS_AT_ONCE]
        part[(cells >= FREE) & (cells <= thresholds.free_at_most)] = GREY_FREE
        part[cells >= thresholds.occupied_at_least] = GREY_OCCUPIED
    return greys


def write_map(
    name: str | Path, grid: OccupancyGrid, thresholds: Thresholds = Thresholds()
) -> tuple[Path, Path]:
    """Write ``name``.pgm and ``name``.yaml at once, and return their paths.

    Raises:
        MapError: the map is empty, or there is no name, or the files cannot be written.
    """
    if not grid.cells.size:
        raise MapError("The map has no cells yet; nothing is saved.")
    import yaml

    name = Path(name)
    if not name.name:
        raise MapError(f"{name} is a folder; name the map's files in it.")
    image_path, yaml_path = (name.with_name(name.name + ending) for ending in (".pgm", ".yaml"))
    height, width = grid.cells.shape
    x, y = grid.origin_xy_m
    header = f"P5\n# {grid.resolution_m:.3f} m/pix\n{width} {height}\n255\n"
    image = yaml.safe_dump({"image": image_path.name}, width=math.inf, allow_unicode=True)
    facts = (
        f"{image}resolution: {grid.resolution_m:.6f}\n"
        f"origin: [{x:.6f}, {y:.6f}, 0.000000]\nnegate: 0\n"
        f"occupied_thresh: {OCCUPIED_THRESH}\nfree_thresh: {FREE_THRESH}\n"
    )
    try:
        replace_files({image_path: (header.encode(), greys_of(grid, thresholds).data), yaml_path: facts})
    except OSError as error:
        raise MapError(f"The map cannot be written to {error.filename}: {error.strerror}.") from None
    return image_path, yaml_path


def write_picture(path: str | Path, grid: OccupancyGrid) -> None:
    """Write the map as a picture for people: PNG, or another format that Pillow knows by the ending."""
    from PIL import Image

    try:
        picture = io.BytesIO()
        picture.name = str(path)  # its ending tells Pillow the format
        Image.fromarray(greys_of(grid)).save(picture)
        replace_file(path, picture.getvalue())
    except (OSError, ValueError) as error:
        raise MapError(f"The map's picture cannot be written to {path}: {reason_of(error)}.") from None


def read_map(path: str | Path) -> OccupancyGrid:
    """Read a map by its YAML file: any image that Pillow reads, in map_server's three modes.

    Raises:
        MapError: a file cannot be read or makes no sense, or the map is turned (yaw).
    """
    path = Path(path)
    facts = _facts_of(path)
    resolution_m = _number(facts, "resolution", path)
    x, y, yaw = _origin(facts, path)
    if abs(math.remainder(yaw, 2.0 * math.pi)) > YAW_MAX_RAD:
        raise MapError(
            f"{path}: the map is turned by {yaw:g} rad (the third number of origin), but only maps with "
            "yaw 0 are understood. Turn the image, and set the number to 0."
        )
    with_alpha = facts.get("mode", "trinary") == "trinary"
    if not isinstance(facts["image"], str):
        raise MapError(f"{path}: image is {facts['image']!r}; it must be the path of the map's image.")
    greys, is_transparent = _greys_in(path.parent / facts["image"], with_alpha)
    cells = _cells(greys, facts, path)
    if is_transparent is not None:
        cells = _without_transparent(cells, is_transparent, str(facts["mode"]))
    try:
        return OccupancyGrid(cells[::-1], resolution_m, (x, y))
    except MapError as error:
        raise MapError(f"{path}: {error}") from None


def _facts_of(path: Path) -> dict:
    import yaml

    class FirstDocument(yaml.SafeLoader):
        """As map_server's reader, takes the first of several documents."""

        def get_single_data(self) -> Any:
            return self.get_data()

    return read_made(path, "The map's file", _checked, MapError, plain=_without_tabs, loader=FirstDocument)


def _checked(facts: Any) -> dict:
    if not isinstance(facts, dict) or not {"image", "resolution", "origin"} <= facts.keys():
        raise MapError("is not a map's YAML file: it lacks image, resolution or origin.")
    return facts


def _without_tabs(text: str) -> str:
    """Return YAML with blanks for the tabs outside of quotes: PyYAML takes none, map_server's reader does."""
    return QUOTED_OR_TAB.sub(lambda found: " " if found[0] == "\t" else found[0], text)


def _greys_in(path: Path, with_alpha: bool) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the image's brightness, (h, w) in [0, 255], row 0 on top; whole numbers are uint8.

    with_alpha: the mean counts the alpha channel too, as map_server's does in the mode trinary. Otherwise
    the second value tells where the image is wholly transparent; it is None without an alpha channel.
    """
    from PIL import Image, UnidentifiedImageError

    try:
        with _opened(path) as image:
            if image.width * image.height > CELLS_MAX:
                raise MapError(
                    f"The map's image {path} has {image.width} x {image.height} cells, of which a map may "
                    f"have {CELLS_MAX:.2g}; cut it, or make its cells larger."
                )
            if image.mode == "F" or (image.mode == "I" and image.format not in WIDE_FORMATS):
                raise MapError(
                    f"The map's image {path} has pixels of 32 bits, whose white nobody knows; "
                    "save it with 8 or 16 bits a pixel."
                )
            if image.mode.startswith("I"):  # 16 bits
                return np.asarray(image, dtype=np.float64) / 257.0, None
            if image.mode == "L":
                return np.asarray(image), None
            has_alpha = "A" in image.getbands() or "transparency" in image.info
            bands = np.asarray(image.convert("RGBA" if has_alpha else "RGB"), dtype=np.float64)
    except UnidentifiedImageError:
        raise MapError(
            f"The map's image {path} cannot be read: it is not an image that Pillow knows."
        ) from None
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise MapError(f"The map's image {path} cannot be read: {reason_of(error)}.") from None
    if not has_alpha or with_alpha:
        return bands.mean(axis=2), None
    return bands[:, :, :3].mean(axis=2), bands[:, :, 3] < 1.0


def _opened(path: Path) -> PillowImage:
    """Return Pillow's image, not decoded yet, without Pillow's limit of size.

    Maps are larger than pictures. But the limit is global in the process, and other code relies on it.
    """
    from PIL import Image

    with _PILLOW_LIMIT:
        limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
        try:
            return Image.open(path)
        finally:
            Image.MAX_IMAGE_PIXELS = limit


def _cells(greys: np.ndarray, facts: dict, path: Path) -> np.ndarray:
    """Return (h, w) int8 cells, row 0 on top. A table converts whole greys, which saves memory."""
    if greys.dtype == np.uint8:
        return _occupancy(np.arange(256.0), facts, path)[greys]
    return _occupancy(greys, facts, path)


def _occupancy(greys: np.ndarray, facts: dict, path: Path) -> np.ndarray:
    """Return int8 cells as map_server would publish them, of greys of any shape."""
    mode = facts.get("mode", "trinary")
    if mode not in MODES:
        raise MapError(f"{path}: mode is {mode!r}; it must be trinary, scale or raw.")
    if _number(facts, "negate", path, 0.0, may_be_flag=True):
        greys = 255.0 - greys
    if mode == "raw":
        return np.where(greys <= OCCUPIED, greys, UNKNOWN).astype(np.int8)
    share = (255.0 - greys) / 255.0
    occupied = _number(facts, "occupied_thresh", path, OCCUPIED_THRESH)
    free = _number(facts, "free_thresh", path, FREE_THRESH)
    if not (0.0 <= free <= 1.0 and 0.0 <= occupied <= 1.0):
        raise MapError(f"{path}: free_thresh {free:g} and occupied_thresh {occupied:g} must be 0 to 1.")
    if mode == "trinary" or free >= occupied:  # then nothing is between, and occupied wins, as in map_server
        between: int | np.ndarray = UNKNOWN
    else:
        between = (1.0 + 98.0 * (share - free) / (occupied - free)).astype(int)
    return np.where(share > occupied, OCCUPIED, np.where(share < free, FREE, between)).astype(np.int8)


def _without_transparent(cells: np.ndarray, is_transparent: np.ndarray, mode: str) -> np.ndarray:
    """Return cells that are unknown where the image is transparent and they are neither free nor occupied.

    Only the mode scale of map_server looks at transparency.
    """
    if mode != "scale":
        return cells
    return np.where(is_transparent & (cells != FREE) & (cells != OCCUPIED), UNKNOWN, cells).astype(np.int8)


def _number(
    facts: dict[str, Any], key: str, path: Path, default: float | None = None, may_be_flag: bool = False
) -> float:
    value: Any = facts.get(key, default)
    if isinstance(value, str) and NUMBER.fullmatch(value):
        value = float(value)
    is_number = isinstance(value, (int, float)) and (may_be_flag or not isinstance(value, bool))
    if not (is_number and abs(value) <= sys.float_info.max):  # NaN fails this test too
        raise MapError(f"{path}: {key} is {value!r}; it must be a number.")
    return float(value)


def _origin(facts: dict, path: Path) -> tuple[float, float, float]:
    origin = facts["origin"]
    if isinstance(origin, list) and len(origin) in (2, 3):
        numbers = dict(zip(("x", "y", "yaw"), [*origin, 0.0]))
        return _number(numbers, "x", path), _number(numbers, "y", path), _number(numbers, "yaw", path)
    raise MapError(f"{path}: origin is {origin!r}; it must be [x, y, yaw].")
