"""The files of the workspace, and which of them depend on which."""

from __future__ import annotations

import re
from collections import defaultdict
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Iterable, Mapping

from changed_tests.references import References, of_python, of_text

_TEXTS = {".launch", ".test", ".world", ".sdf", ".yaml", ".rviz", ".sh", ".xml", ".config", ".json"}
_PACKAGE = re.compile(r"src/(?:(?:helpers|extensions)/)?([^/]+)/")
_ROOTS = re.compile(r"src/(?:(?:helpers|extensions)/)?[^/]+/(?:src|ros)/|scripts/")
_TEST_FOLDER = re.compile(r"(?:src/(?:(?:helpers|extensions)/)?[^/]+/test|tests)/")
_NEEDED = re.compile(r"depend[^>]*>\s*([\w-]+)\s*<")
_ATTRIBUTES = ":attributes"
"""Behind a package's path: what its names may need that it imports only when asked (`__getattr__`)."""


class Workspace:
    """Files by their path from the root, with `/`.

    A deleted file is still one: what refers to it depends on it.
    """

    def __init__(self, root: Path, files: Iterable[str]) -> None:
        """files: all paths, the deleted ones too."""
        self.root = Path(root)
        self.files = frozenset(files)
        self.unread: dict[str, str] = {}
        """Python files that cannot be parsed, and why."""

    def dependents(self, changed: str) -> set[str]:
        """Return the file and all that depend on it, directly or by others.

        Worlds, models and configurations are often opened by a part of their name. So for a change of such a
        file loose names count, too. They do not count further on: half of the code has the word "hold".
        """
        found: set[str] = set()
        todo = {changed}
        while loose := {path for path in todo if path not in found and self._is_data(path)}:
            found |= loose
            for path in loose:
                todo |= self._dependents[path] | self._loose_dependents(path)
        while todo:
            path = todo.pop()
            if path not in found or path == changed:
                found.add(path)
                todo |= self._dependents[path] - found
        return {path.removesuffix(_ATTRIBUTES) for path in found} & self.files

    def is_python(self, path: str) -> bool:
        """Whether a file is Python code: by its name, or a node by its first line."""
        if path.endswith(".py"):
            return True
        if "/nodes/" not in path or PurePosixPath(path).suffix:
            return False
        return not (self.root / path).is_file() or "python" in self._text(path).partition("\n")[0]

    @cached_property
    def _references(self) -> Mapping[str, References]:
        found = {}
        for path in self.files:
            if not (self.root / path).is_file():
                continue
            if self.is_python(path):
                try:
                    found[path] = of_python(self._text(path), _package(path), bool(_test_folder(path)))
                except SyntaxError as error:
                    self.unread[path] = f"line {error.lineno}: {error.msg}"
            elif PurePosixPath(path).suffix in _TEXTS:
                found[path] = of_text(self._text(path))
        return found

    @cached_property
    def _dependents(self) -> Mapping[str, set[str]]:
        """By a file: those that import it, name it, or whose conftest it is."""
        dependents: dict[str, set[str]] = defaultdict(set)
        packages = {package_of(path) for path in self.files} - {""}
        named, started = defaultdict(set), defaultdict(set)
        for path in self.files:
            for name in names(path):
                named[name].add(path)
            for name in program_names(path) - packages:
                started[name].add(path)
        for path, references in self._references.items():
            for module in references.modules:
                for found in self._modules_of(module, path):
                    dependents[found].add(path)
            # A package that imports by name does so only for those who take its names.
            asker = path + _ATTRIBUTES if path.endswith("/__init__.py") else path
            for word in references.words:
                for found in {*self._named_by(path, word, named), *self._module_called(word)} - {path}:
                    dependents[found].add(asker)
            for name in references.programs:
                for found in started.get(name, ()):
                    dependents[found].add(path)
        for path in self.files:
            if path.endswith("/__init__.py"):
                dependents[path].add(path + _ATTRIBUTES)
            if path.endswith("/conftest.py"):
                folder = path.removesuffix("conftest.py")
                dependents[path].update(other for other in self.files if other.startswith(folder))
        return dependents

    def _named_by(self, asker: str, word: str, named: Mapping[str, set[str]]) -> set[str]:
        """Return the files that a word in a file names.

        A library's module is imported. Only a test may read it by its name alone: each has a warm_up.py.
        """
        found = named.get(word, set())
        return found if _test_folder(asker) else {path for path in found if not _is_library(path)}

    def readers(self, changed: str) -> set[str]:
        """Return the file and those tests that may read its text: they have its name in a string."""
        called = names(changed)
        tests = {
            path for path, found in self._references.items() if _test_folder(path) and called & found.words
        }
        return {changed, *tests}

    def dependents_of_package(self, package: str) -> set[str]:
        """Return the files of a package and of those that need it (package.xml), and what depends on them."""
        concerned = {package}
        while more := {
            name for name, needed in self._needed.items() if name not in concerned and needed & concerned
        }:
            concerned |= more
        found: set[str] = set()
        todo = {
            path
            for path in self.files
            if package_of(path) in concerned or self._heads.get(path, set()) & concerned
        }
        while todo:
            path = todo.pop()
            found.add(path)
            todo |= self._dependents[path] - found
        return {path.removesuffix(_ATTRIBUTES) for path in found} & self.files

    @cached_property
    def _needed(self) -> Mapping[str, set[str]]:
        """By a package: those that its package.xml names."""
        paths = {
            path for path in self.files if path.endswith("/package.xml") and (self.root / path).is_file()
        }
        return {package_of(path): set(_NEEDED.findall(self._text(path))) for path in paths}

    @cached_property
    def _heads(self) -> Mapping[str, set[str]]:
        """By a file: names that may be those of packages whose messages or programs it uses."""
        return {
            path: {module.partition(".")[0] for module in found.modules} | found.words
            for path, found in self._references.items()
        }

    def _is_data(self, path: str) -> bool:
        """Whether a file is neither code nor starts any."""
        return not self.is_python(path) and PurePosixPath(path).suffix not in (".launch", ".test")

    def _loose_dependents(self, path: str) -> set[str]:
        """Return the files that may open a file by its name without the suffix, or by a pattern."""
        called = names(path) | loose_names(path)
        return {
            other
            for other, references in self._references.items()
            if other != path
            and (
                not called.isdisjoint(references.words)
                or any(_matches(pattern, name) for pattern in references.patterns for name in called)
            )
        }

    def _modules_of(self, dotted: str, asker: str) -> set[str]:
        """Return the files that Python runs to import a name, `package.module.name` or `package.*`."""
        parts = dotted.split(".")
        found: list[str] = []
        for count in range(1, len(parts) + 1):
            module = self._module_index.get(".".join(parts[:count]))
            if module is None and count == 1:
                module = self._helper_index.get((_test_folder(asker), parts[0]))
            if module is None:
                break
            found.append(module)
        if 0 < len(found) < len(parts) and found[-1].endswith("/__init__.py"):
            found.append(found[-1] + _ATTRIBUTES)  # the rest is a name in the package
        return set(found)

    def _module_called(self, dotted: str) -> set[str]:
        """Return the files that Python runs to import a module whose name stands in a string."""
        is_module = "." in dotted and dotted in self._module_index
        return self._modules_of(dotted, "") if is_module else set()

    @cached_property
    def _module_index(self) -> Mapping[str, str]:
        return {_module(path): path for path in self.files if path.endswith(".py") and not _test_folder(path)}

    @cached_property
    def _helper_index(self) -> Mapping[tuple[str, str], str]:
        """What tests import that lies beside them, by the folder of tests and the name."""
        return {
            (_test_folder(path), PurePosixPath(path).stem): path
            for path in self.files
            if path.endswith(".py") and _test_folder(path)
        }

    def _text(self, path: str) -> str:
        return (self.root / path).read_text(encoding="utf-8", errors="replace")


def names(path: str) -> set[str]:
    """Return the names by which any file refers to a file that it does not import."""
    pure = PurePosixPath(path)
    if pure.name in ("__init__.py", "conftest.py"):
        return set()
    if _is_node(path):  # many nodes are called as their package or a topic is
        return {f"{pure.parts[-3]} {pure.name}", f"nodes {pure.name}"}
    return {pure.name}


def program_names(path: str) -> set[str]:
    """Return the name by which what starts programs may start this one, without its package."""
    pure = PurePosixPath(path)
    return {pure.stem} if _is_node(path) or pure.suffix == ".launch" else set()


def loose_names(path: str) -> set[str]:
    """Return the names by which a file of data may be opened: without the suffix, or its model's."""
    pure = PurePosixPath(path)
    if "models" in pure.parts[:-2]:
        return {pure.parts[pure.parts.index("models") + 1]}
    return {pure.name.partition(".")[0]} - {""}


def _is_node(path: str) -> bool:
    return re.fullmatch(r"src/(?:(?:helpers|extensions)/)?[^/]+/nodes/[^/]+", path) is not None


def package_of(path: str) -> str:
    """Return the name of the package that a file belongs to; empty: none."""
    found = _PACKAGE.match(path)
    return found[1] if found else ""


def _is_library(path: str) -> bool:
    return path.endswith(".py") and _ROOTS.match(path) is not None and not path.startswith("scripts/")


def _matches(pattern: str, name: str) -> bool:
    return re.fullmatch(".*".join(map(re.escape, pattern.split("*"))), name) is not None


def _test_folder(path: str) -> str:
    found = _TEST_FOLDER.match(path)
    return found[0] if found else ""


def _module(path: str) -> str:
    """Return the dotted name by which a Python file is imported."""
    inside = _ROOTS.sub("", path, count=1) if _ROOTS.match(path) else path
    return inside.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def _package(path: str) -> str:
    """Return the package that a file's relative imports begin at."""
    module = _module(path)
    return module if path.endswith("/__init__.py") else module.rpartition(".")[0]
