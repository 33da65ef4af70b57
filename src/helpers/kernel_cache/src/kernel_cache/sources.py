"""The sources that a kernel is compiled from: its file, and what that imports of packages with kernels."""

from __future__ import annotations

import ast
import hashlib
import sys
from functools import cache
from pathlib import Path
from typing import Iterator

DIGITS = 16


@cache
def digest_of(file: Path) -> str:
    """Return a digest of all the sources of the kernels in a file; they must not change meanwhile."""
    digest = hashlib.sha256()
    for path in sorted(sources_of(file)):
        digest.update(str(path.relative_to(_root_of(path))).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:DIGITS]


def sources_of(file: Path) -> set[Path]:
    """Return the file, and all that it imports of packages with kernels, directly or through others."""
    found, new = {file}, [file]
    while new:
        imported = _imported(new.pop()) - found
        found |= imported
        new += imported
    return found


def _root_of(file: Path) -> Path:
    """Return the folder that Python has on its path for a file's package."""
    folder = file.parent
    while (folder / "__init__.py").is_file():
        folder = folder.parent
    return folder


@cache
def _imported(file: Path) -> frozenset[Path]:
    """Return the files of its own package, and of others with kernels, that a file imports itself."""
    root = _root_of(file)
    inside = file.relative_to(root).with_suffix("").parts
    names: set[tuple[str, ...]] = set()
    for node in _statements(ast.parse(file.read_bytes(), str(file))):
        if isinstance(node, ast.Import):
            names |= {tuple(alias.name.split(".")) for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = inside[: len(inside) - node.level] if node.level else ()
            module = (*above, *(node.module.split(".") if node.module else ()))
            names |= {module, *((*module, alias.name) for alias in node.names)}
    ours = {root.joinpath(*name) for name in names if name[:1] == inside[:1]}
    candidates = {path.with_suffix(".py") for path in ours} | {path / "__init__.py" for path in ours}
    others = {path for name in names if name[:1] != inside[:1] for path in _of_another_package(name)}
    return frozenset(path for path in candidates if path.is_file()) | others


def _of_another_package(name: tuple[str, ...]) -> Iterator[Path]:
    """Yield the file of an imported module of another package, if that has a `warm_up`: it has kernels then.

    The module is loaded already, because a kernel's imports stand before it. So Python knows its file.
    """
    file = getattr(sys.modules.get(".".join(name)), "__file__", None)
    if file is None or not name[0]:
        return
    path = Path(file).resolve()
    if (_root_of(path) / name[0] / "warm_up.py").is_file():
        yield path


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all statements, also those in functions and branches; expressions hold no import.

    `ast.walk` visits each expression, too. That took 0.05 s of each node's start.
    """
    for field in ("body", "orelse", "handlers", "finalbody", "cases"):
        for statement in getattr(tree, field, ()):
            yield statement
            yield from _statements(statement)
