"""Import every module of some packages, so that Python keeps the byte code of all that they need.

usage: import_all.py FOLDER ...    (of packages on the path)
"""

from __future__ import annotations

import importlib
import pkgutil
import sys
from pathlib import Path


def main(folders: list[str]) -> None:
    """Import the packages of these folders, except modules that need ROS, which may not be installed yet."""
    for folder in map(Path, folders):
        if not (folder / "__init__.py").is_file():
            continue
        for module in pkgutil.walk_packages([str(folder)], f"{folder.name}."):
            if module.name.endswith("__main__"):
                continue
            print(f"compiling {module.name}", flush=True)
            try:
                importlib.import_module(module.name)
            except ImportError as error:
                print(f"{module.name} waits for its first use: {error}")


if __name__ == "__main__":
    main(sys.argv[1:])
