"""Finds the file that a uri in a description means, and refuses files outside the model folders.

A file is looked for where Gazebo 11 looks for it: ``model://name/...`` in every folder of the model path,
``package://`` also among ROS's packages, ``file://`` and relative uris beside the file that names them and
in the folders of ``GAZEBO_RESOURCE_PATH``, uris of Fuel in its local cache (nothing is downloaded). What is
found must lie inside these folders, whatever ``..`` or symbolic links lead there. ``%20`` may stand for a
blank.
"""

from __future__ import annotations

import glob
import os
from contextlib import suppress
from pathlib import Path
from typing import Iterable, Sequence
from urllib.parse import unquote

from simulation_tools.sdf.fuel_cache import SCHEMES as FUEL_SCHEMES
from simulation_tools.sdf.fuel_cache import FuelError, cached, own_folder

MODEL_PATH_VARIABLE = "GAZEBO_MODEL_PATH"
PACKAGE_PATH_VARIABLE = "ROS_PACKAGE_PATH"
RESOURCE_PATH_VARIABLE = "GAZEBO_RESOURCE_PATH"


class UriError(ValueError):
    """A uri cannot be followed. The text is a clause; the caller adds file and line."""


def model_path_from_environment() -> tuple[Path, ...]:
    """Return the folders of ``GAZEBO_MODEL_PATH``, followed by the model folder of this source tree."""
    folders, shipped = _folders_of(MODEL_PATH_VARIABLE), shipped_models()
    if shipped.is_dir() and shipped not in folders:
        folders.append(shipped)
    return tuple(folders)


def shipped_models() -> Path:
    """Return the model folder of this source tree."""
    return Path(__file__).resolve().parents[3] / "models"


def resolve(uri: str, model_path: Sequence[Path], folder: Path | None) -> Path:
    """Return the absolute path of an existing file or folder.

    folder: of the file that holds the uri, None for bare text. Raises UriError.
    """
    try:
        return _resolved(uri.strip(), model_path, folder)
    except UriError as error:
        plain = unquote(uri.strip())
        if plain != uri.strip():
            with suppress(UriError):
                return _resolved(plain, model_path, folder)
        raise error from None


def _resolved(uri: str, model_path: Sequence[Path], folder: Path | None) -> Path:
    if "\0" in uri:
        raise UriError(f'the uri "{uri!r}" is not a path')
    scheme, separator, rest = uri.partition("://")
    if not separator:
        return _relative(uri, model_path, folder)
    if scheme == "model":
        return _model(uri, rest, model_path, folder)
    if scheme == "package":
        return _package(uri, rest, model_path)
    if scheme == "file":
        return _file(uri, rest, model_path, folder)
    if scheme in FUEL_SCHEMES:
        try:
            return cached(uri)
        except FuelError as error:
            raise UriError(str(error)) from None
    raise UriError(
        f'the uri "{uri}" has an unknown scheme; use model://, package://, file:// or a relative path'
    )


def _folders_of(variable: str) -> list[Path]:
    return [Path(folder) for folder in os.environ.get(variable, "").split(os.pathsep) if folder]


def _model(uri: str, rest: str, model_path: Sequence[Path], folder: Path | None) -> Path:
    name = rest.split("/", 1)[0]
    if name in ("", ".", ".."):
        raise UriError(f'the uri "{uri}" names no model')
    having = [root for root in model_path if (root / name).is_dir()]
    if not having:
        home = own_folder(name, folder)
        if home is not None:
            return _existing(home / rest[len(name) :].lstrip("/"), (home,), uri)
        searched = ", ".join(str(root) for root in model_path) or "none"
        raise UriError(f'there is no model "{name}" in the folders of {MODEL_PATH_VARIABLE} ({searched})')
    # Two folders may have a model of this name, and only the second one the file.
    wanted = f"{name}/model.config" if rest.rstrip("/") == name else rest
    found = next((root for root in having if (root / wanted).exists()), having[0])
    return _existing(found / rest, (found, found / name), uri)  # the model may itself be a link


def _package(uri: str, rest: str, model_path: Sequence[Path]) -> Path:
    """Return a file of a ROS package. A folder of ``ROS_PACKAGE_PATH`` is or holds packages."""
    name = rest.split("/", 1)[0]
    if name in ("", ".", ".."):
        raise UriError(f'the uri "{uri}" names no package')
    folders = _folders_of(PACKAGE_PATH_VARIABLE)
    places = [folder / name for folder in (*model_path, *folders)]
    places += [folder for folder in folders if folder.name == name]
    places += [place for folder in folders for place in folder.glob(f"*/{glob.escape(name)}")]
    for place in places:
        if place.is_dir() and _exists(place.parent / rest):
            return _existing(place.parent / rest, (place,), uri)
    raise UriError(f'the uri "{uri}" leads to no file in {MODEL_PATH_VARIABLE} or {PACKAGE_PATH_VARIABLE}')


def _file(uri: str, rest: str, model_path: Sequence[Path], folder: Path | None) -> Path:
    if os.path.isabs(rest):
        return _existing(Path(rest), _allowed(model_path, folder), uri)
    return _first_existing(rest, (*_folders_of(RESOURCE_PATH_VARIABLE),), uri, model_path, folder)


def _relative(uri: str, model_path: Sequence[Path], folder: Path | None) -> Path:
    if os.path.isabs(uri):
        return _existing(Path(uri), _allowed(model_path, folder), uri)
    if folder is None:
        raise UriError(f'the relative uri "{uri}" has no folder to start from; use model://')
    return _first_existing(uri, (folder, *_folders_of(RESOURCE_PATH_VARIABLE)), uri, model_path, folder)


def _first_existing(
    rest: str, starts: Sequence[Path], uri: str, model_path: Sequence[Path], folder: Path | None
) -> Path:
    """Return the first file of that name below one of the folders."""
    places = [start / rest for start in (*starts, *(() if folder is None else (folder,)))]
    found = next((place for place in places if _exists(place)), None)
    if found is None and not places:
        raise UriError(f'the uri "{uri}" is searched in {RESOURCE_PATH_VARIABLE}, which is empty')
    return _existing(found or places[0], _allowed(model_path, folder), uri)


def _allowed(model_path: Sequence[Path], folder: Path | None) -> tuple[Path, ...]:
    own = () if folder is None else (folder,)
    return (*model_path, *_folders_of(RESOURCE_PATH_VARIABLE), *own)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, RuntimeError):  # a name too long, a loop of links
        return False


def _existing(path: Path, roots: Iterable[Path], uri: str) -> Path:
    try:
        real = path.resolve()
        inside = any(_is_within(real, root) for root in roots)
        exists = real.exists()
    except (OSError, RuntimeError):  # a name too long, a loop of links
        inside, exists = True, False
    if not inside:
        raise UriError(f'the uri "{uri}" leaves the model folders')
    if not exists:
        raise UriError(f'the uri "{uri}" leads to {path}, which does not exist')
    return real


def _is_within(path: Path, root: Path) -> bool:
    # Check the folder itself and the target of its link, because a devel space consists of links.
    real_root = root.resolve()
    return path == real_root or real_root in path.parents
