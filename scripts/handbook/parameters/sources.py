"""Python sources that are read without being imported: their classes, constants and imports."""

from __future__ import annotations

import ast
import math
import re
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from handbook.pages import ROOT

IS_NODE = re.compile(r"\brospy\b|\w_ros\b")
"""What a script holds that talks to ROS."""
PARTS = ("src", "ros")
"""Folders of a package that hold modules."""


@dataclass
class Module:
    """A module, or the script of a node."""

    path: Path
    sources: Sources

    @cached_property
    def tree(self) -> ast.Module:
        """Its syntax tree."""
        return ast.parse(self.path.read_text(encoding="utf-8"))

    @cached_property
    def constants(self) -> dict[str, ast.expr]:
        """What stands in the module itself, by name."""
        found = {}
        for node in self.tree.body:
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                found[node.targets[0].id] = node.value
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.value:
                found[node.target.id] = node.value
        return found

    @cached_property
    def classes(self) -> dict[str, ast.ClassDef]:
        """Its classes, by name."""
        return {node.name: node for node in self.tree.body if isinstance(node, ast.ClassDef)}

    @cached_property
    def imports(self) -> dict[str, tuple[str, str]]:
        """By the name here: the module, and the name there; empty if the name is the module itself."""
        found = {}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                found.update({alias.asname or alias.name: (node.module, alias.name) for alias in node.names})
            elif isinstance(node, ast.Import):
                found.update({alias.asname or alias.name: (alias.name, "") for alias in node.names})
        return found

    def find_class(self, name: str, depth: int = 0) -> tuple[Module, ast.ClassDef] | None:
        """Return a class that this module knows by this name, and the module that has it."""
        if name in self.classes:
            return self, self.classes[name]
        home = self._home(name)
        return home.find_class(self.imports[name][1], depth + 1) if home and depth < 9 else None

    def _home(self, name: str) -> Module | None:
        """Return the module from which a name is imported here."""
        where, what = self.imports.get(name, ("", ""))
        if not what:
            return None
        known = self.sources.module(where)
        if known and "." not in where:  # a library that imports its names when they are asked for
            return self.sources.module(f"{where}.library") or known
        return known

    def value(self, expression: ast.expr, depth: int = 0) -> Any:
        """Return what an expression of the module is.

        Raises:
            LookupError: it needs more than constants, classes' defaults and `math`.
        """
        bound = {node.id for node in ast.walk(expression) if isinstance(node, ast.Name)}
        own = {
            node.id
            for each in ast.walk(expression)
            if isinstance(each, ast.comprehension)
            for node in ast.walk(each.target)
            if isinstance(node, ast.Name)
        }
        names = {name: self._named(name, depth) for name in bound - own - BUILTINS.keys()}
        try:
            code = compile(ast.Expression(expression), str(self.path), "eval")
            return eval(code, {"__builtins__": BUILTINS, **names})
        except Exception as error:
            raise LookupError(f"{ast.unparse(expression)} in {self.path}: {error}") from None

    def _named(self, name: str, depth: int) -> Any:
        if depth > 9:
            raise LookupError(name)
        if name in self.constants:
            return self.value(self.constants[name], depth + 1)
        if self.imports.get(name) == ("math", ""):
            return math
        found = self.find_class(name)
        if found:
            home, node = found
            return SimpleNamespace(**defaults(home, node, depth + 1))
        origin = self._home(name)
        if origin:
            return origin._named(self.imports[name][1], depth + 1)
        raise LookupError(f"{name} in {self.path}")


BUILTINS: dict[str, Any] = {
    "frozenset": frozenset, "tuple": tuple, "dict": dict, "float": float, "int": int, "str": str, "len": len,
    "range": range, "round": round, "zip": zip, "field": lambda **given: given.get("default"), "bool": bool,
    "limited": lambda default, *limits, **more: default,
}  # fmt: skip


def defaults(module: Module, node: ast.ClassDef, depth: int = 0) -> dict[str, Any]:
    """Return the defaults of a dataclass's fields; those that cannot be told are left out."""
    found = {}
    for part in node.body:
        if isinstance(part, ast.AnnAssign) and isinstance(part.target, ast.Name) and part.value:
            try:
                found[part.target.id] = module.value(part.value, depth)
            except LookupError:
                continue
    return found


@dataclass
class Sources:
    """All modules and nodes of the workspace."""

    root: Path = ROOT
    _modules: dict[str, Module | None] = field(default_factory=dict)

    def module(self, name: str) -> Module | None:
        """Return a module of ours by its name, or None."""
        if name not in self._modules:
            file = Path(*name.split("."))
            for package in _packages(self.root):
                for part in PARTS:
                    for path in (
                        package / part / file.with_suffix(".py"),
                        package / part / file / "__init__.py",
                    ):
                        if path.is_file():
                            self._modules[name] = Module(path, self)
            self._modules.setdefault(name, None)
        return self._modules[name]

    def nodes(self) -> dict[tuple[str, str], Module]:
        """Return the script of each node, by package and name."""
        found = {}
        for path in sorted(self.root.glob("src/**/nodes/*")):
            if path.is_file() and not path.suffix and IS_NODE.search(path.read_text(encoding="utf-8")):
                found[path.parents[1].name, path.name] = Module(path, self)
        return found


@cache
def _packages(root: Path) -> tuple[Path, ...]:
    """Return the folders of all Python packages."""
    return tuple(path.parent for path in sorted(root.glob("src/**/setup.py")))
