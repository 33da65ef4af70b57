#!/usr/bin/env python3
"""Write the map of each package's folders and modules into its page, from the first lines of the docstrings.

usage: room_maps.py

The map lists the ROS side and the folders directly in a library, but not the folders in those. It also lists
the modules of a library that has at most two folders. In this script a folder of Python modules is called a
room.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = {path.parent.name: path.parent for path in sorted(ROOT.glob("src/**/setup.py"))}
"""The folder of each package."""
PAGES = {
    name: page if (page := folder / "doc/how_it_works.md").is_file() else folder / "README.md"
    for name, folder in FOLDERS.items()
}
"""The page of each package that holds its map."""
MODULES_UP_TO_ROOMS = 2
"""A library with more folders than these is shown by its folders alone."""
BEGIN, END = "<!-- rooms: scripts/room_maps.py writes from here -->\n", "<!-- to here -->"
BLOCK = re.compile(f"(?<={BEGIN}).*?(?={END})", re.S)


def summary(module: Path) -> str:
    """Return the first line of a module's docstring."""
    text = ast.get_docstring(ast.parse(module.read_text(encoding="utf-8"))) or ""
    return text.partition("\n")[0]


def room_map(package: str) -> str:
    """Return the list of a package's rooms, in Markdown."""
    top = FOLDERS[package]
    library, edge = top / "src" / package, top / "ros" / f"{package}_ros"
    rooms = [*edge.glob("__init__.py"), *sorted(library.glob("*/__init__.py"))]
    modules = [path for path in sorted(library.glob("*.py")) if path.stem != "__init__"]
    if sum(library in path.parents for path in rooms) > MODULES_UP_TO_ROOMS:
        modules = []
    rows = [(f"{path.parent.relative_to(top)}/", path) for path in rooms]
    rows += [(str(path.relative_to(top)), path) for path in modules]
    lines = [f"- [`{name}`]({name_from(package)}{name}): {summary(path)}" for name, path in rows]
    return "\n".join(["", f"In `{top.relative_to(ROOT)}/`:", "", *lines, "", ""])


def name_from(package: str) -> str:
    """Return the relative path from a package's page to its folder."""
    return "../" if PAGES[package].parent.name == "doc" else ""


def main() -> None:
    """Write all maps."""
    for package, page in PAGES.items():
        text = page.read_text(encoding="utf-8")
        page.write_text(BLOCK.sub(lambda _, package=package: room_map(package), text), encoding="utf-8")


if __name__ == "__main__":
    main()
