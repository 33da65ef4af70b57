"""No two files import each other, not even for their types: each can be read after those below it."""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Iterator

import pytest

ROOT = Path(__file__).resolve().parents[2]
LIBRARIES = sorted(path.parent for path in ROOT.glob("src/*/src/*/__init__.py")) + sorted(
    path.parent for path in ROOT.glob("src/*/ros/*/__init__.py")
)


@pytest.mark.parametrize("library", LIBRARIES, ids=lambda path: path.name)
def test_no_circle(library):
    modules = {module_of(path, library): path for path in library.rglob("*.py")}
    graph = {name: set(imported(path, modules)) - {name} for name, path in modules.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))


def module_of(path: Path, library: Path) -> str:
    return ".".join(path.relative_to(library.parent).with_suffix("").parts).removesuffix(".__init__")


def imported(path: Path, modules: dict[str, Path]) -> Iterator[str]:
    """Yield the modules of the library that a file names, also for types and inside functions."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            inner = {f"{node.module}.{alias.name}" for alias in node.names} & set(modules)
            yield from inner or {node.module} & set(modules)
        elif isinstance(node, ast.Import):
            yield from {alias.name for alias in node.names} & set(modules)


def test_a_circle_of_types_is_found(tmp_path):
    library = tmp_path / "rooms"
    library.mkdir()
    (library / "__init__.py").touch()
    (library / "a.py").write_text("from rooms.b import B\n")
    (library / "b.py").write_text(
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from rooms import a\n"
    )
    with pytest.raises(pytest.fail.Exception, match=r"rooms\.\w imports rooms\.\w imports rooms\.\w"):
        test_no_circle(library)
