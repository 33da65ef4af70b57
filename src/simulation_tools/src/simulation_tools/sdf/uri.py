"""Finds the file that a uri in a description means, and refuses files outside the model folders.

``model://name/...`` is looked up in the folders of the model path. ``file://`` and relative uris must end
inside the model path or the folder of the file that names them, whatever ``..`` or symbolic links they go
through.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Iterable, Sequence

MODEL_PATH_VARIABLE = "GAZEBO_MODEL_PATH"


class UriError(ValueError):
    """A uri cannot be followed. The text is a clause; the caller adds file and line."""


def model_path_from_environment() -> tuple[Path, ...]:
    """Return the folders of ``GAZEBO_MODEL_PATH``, followed by the model folder of this source tree."""
    folders = [Path(folder) for folder in os.environ.get(MODEL_PATH_VARIABLE, "").split(os.pathsep) if folder]
    shipped = Path(__file__).resolve().parents[3] / "models"
    if shipped.is_dir() and shipped not in folders:
        folders.append(shipped)
    return tuple(folders)


def resolve(uri: str, model_path: Sequence[Path], folder: Path | None) -> Path:
    """Return the absolute path of an existing file or folder.

    folder: of the file that holds the uri, None for bare text. Raises UriError.
    """
    uri = uri.strip()
    if "\0" in uri:
        raise UriError(f'the uri "{uri!r}" is not a path')
    scheme, separator, rest = uri.partition("://")
    if not separator:
        return _relative(uri, model_path, folder)
    if scheme == "model":
        return _model(uri, rest, model_path)
    if scheme == "file":
        return _existing(Path(rest), _allowed(model_path, folder), uri)
    raise UriError(f'the uri "{uri}" has an unknown scheme; use model://, file:// or a relative path')


def _model(uri: str, rest: str, model_path: Sequence[Path]) -> Path:
    name = rest.split("/", 1)[0]
    if name in ("", ".", ".."):
        raise UriError(f'the uri "{uri}" names no model')
    for root in model_path:
        if (root / name).is_dir():
            return _existing(root / rest, (root, root / name), uri)  # the model may itself be a link
    searched = ", ".join(str(root) for root in model_path) or "none"
    raise UriError(f'there is no model "{name}" in the folders of {MODEL_PATH_VARIABLE} ({searched})')


def _relative(uri: str, model_path: Sequence[Path], folder: Path | None) -> Path:
    if folder is None and not os.path.isabs(uri):
        raise UriError(f'the relative uri "{uri}" has no folder to start from; use model://')
    return _existing((folder or Path("/")) / uri, _allowed(model_path, folder), uri)


def _allowed(model_path: Sequence[Path], folder: Path | None) -> tuple[Path, ...]:
    return (*model_path, folder) if folder is not None else tuple(model_path)


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
