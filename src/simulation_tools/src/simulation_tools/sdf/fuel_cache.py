"""Finds models of Fuel (https://fuel.gazebosim.org) in the cache of Gazebo's tools; downloads nothing.

``ign fuel download -u URI`` or ``gz fuel download -u URI`` fill the cache. A model lies in
``SERVER/OWNER/models/NAME/VERSION``, its owner and name in small letters.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from urllib.parse import unquote

SCHEMES = ("http", "https", "fuel")
SERVERS = ("fuel.gazebosim.org", "fuel.ignitionrobotics.org", "api.ignitionfuel.org")
"""Names that Fuel's server has had. A model may lie below any of them."""
CACHES = (("GZ_FUEL_CACHE_PATH", ".gz/fuel"), ("IGN_FUEL_CACHE_PATH", ".ignition/fuel"))
"""Variables that say where the cache is, and where it is in the home folder without them."""
_URI = re.compile(
    r"(?:https?|fuel)://(?P<server>[^/]+)/(?:[\d.]+/)?(?P<owner>[^/]+)/(?:fuel/)?models/(?P<name>[^/]+)"
    r"(?:/(?P<version>\d+|tip))?(?:/files/(?P<file>.+))?/?"
)


class FuelError(ValueError):
    """A model of Fuel is not in the cache. The text is a clause."""


def cached(uri: str) -> Path:
    """Return the folder of a model, or one of its files, in the local cache.

    Without a version the newest one is taken. Raises FuelError.
    """
    parts = _URI.fullmatch(uri)
    if parts is None:
        raise FuelError(f'the uri "{uri}" has an unknown scheme or names no model of Fuel')
    owner, name = (unquote(parts[key]).lower() for key in ("owner", "name"))
    if {owner, name} & {".", ".."} or "/" in owner + name:
        raise FuelError(f'the uri "{uri}" names no model')
    for folder in _folders_of_model(parts["server"], owner, name):
        home = _version(folder, parts["version"])
        if home is None:
            continue
        path = (home / unquote(parts["file"] or "")).resolve()
        if path.exists():
            if home.resolve() not in (path, *path.parents):
                raise FuelError(f'the uri "{uri}" leaves the model\'s folder')
            return path
    raise FuelError(
        f'"{uri}" is not in the local cache of Fuel; "ign fuel download -u {uri}" brings it there'
    )


def own_folder(name: str, folder: Path | None) -> Path | None:
    """Return the folder of the cached model that a file belongs to, if it is called so; None if it is not.

    A model of Fuel names its own files ``model://NAME/...``, but its folder is ``name/VERSION``. folder: of
    the file.
    """
    for home in () if folder is None else (folder, *folder.parents):
        if (home / "model.config").is_file():
            is_own = home.name.isdigit() and home.parent.name == name.lower()
            return home if is_own and home.parent.parent.name == "models" else None
    return None


def _folders_of_model(server: str, owner: str, name: str) -> list[Path]:
    homes = [Path(os.environ.get(variable) or Path.home() / usual) for variable, usual in CACHES]
    servers = dict.fromkeys((server.lower(), *SERVERS))
    folders = [home / place / owner / "models" / name for home in homes for place in servers]
    return [folder for folder in folders if folder.is_dir()]


def _version(folder: Path, wanted: str | None) -> Path | None:
    versions = [child for child in folder.iterdir() if child.name.isdigit()]
    if wanted not in (None, "tip"):
        versions = [child for child in versions if child.name == wanted]
    return max(versions, key=lambda child: int(child.name), default=None)
