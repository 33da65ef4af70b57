"""What the Python files of the workspace import, and which files of a package are nodes."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path


def imports(path: Path) -> set[str]:
    """Return the top-level names of all that a file imports."""
    return {name.split(".")[0] for name in dotted_imports(path)}


@cache
def dotted_imports(path: Path) -> frozenset[str]:
    """Return the full names of all that a file imports: modules, and what is taken from them."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), str(path))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return frozenset(names)


def python_nodes(package: Path) -> list[Path]:
    """Return the executables in a package's ``nodes/`` that are Python."""
    files = (path for path in package.glob("nodes/*") if path.is_file())
    return [path for path in files if path.read_bytes().startswith(b"#!/usr/bin/env python3")]


def folder_of(package: str) -> Path:
    """Return the folder of a Python package of the workspace, by its name."""
    (found,) = Path(__file__).resolve().parents[2].glob(f"src/**/{package}/setup.py")
    return found.parent
