"""What the Python files of the workspace import, and which files of a package are nodes."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def imports(path: Path) -> set[str]:
    """Return the top-level names of all that a file imports."""
    return {name.split(".")[0] for name in dotted_imports(path)}


STRING = re.compile(r'"""(?:[^\\]|\\.)*?"""', re.S)
IMPORT = re.compile(r"^[ \t]*((?:from \w[\w.]* )?import (?:\([^)]*\)|[^\n(]*))", re.M)
"""Only these statements are parsed: to parse all files takes 40 times as long."""


@cache
def dotted_imports(path: Path) -> frozenset[str]:
    """Return the full names of all that a file imports: modules, and what is taken from them."""
    names: set[str] = set()
    for statement in IMPORT.findall(STRING.sub("", path.read_text(encoding="utf-8"))):
        (node,) = ast.parse(statement).body
        of = f"{node.module}." if isinstance(node, ast.ImportFrom) else ""
        names |= {of + alias.name for alias in node.names}
    return frozenset(names)


def python_nodes(package: Path) -> list[Path]:
    """Return the executables in a package's ``nodes/`` that are Python."""
    files = (path for path in package.glob("nodes/*") if path.is_file())
    return [path for path in files if path.read_bytes().startswith(b"#!/usr/bin/env python3")]


@cache
def packages() -> list[Path]:
    """Return the folders of the Python packages of the workspace."""
    return sorted(path.parent for path in ROOT.glob("src/**/setup.py"))


@cache
def sources(*places: str) -> list[Path]:
    """Return the Python files of nodes, of their ROS side and of the libraries; or only of these places."""
    found = [path for package in packages() for path in python_nodes(package)]
    for place in places or ("ros", "src"):
        found += [path for package in packages() for path in package.glob(f"{place}/**/*.py")]
    return sorted(found)


def folder_of(package: str) -> Path:
    """Return the folder of a Python package of the workspace, by its name."""
    (found,) = (folder for folder in packages() if folder.name == package)
    return found
