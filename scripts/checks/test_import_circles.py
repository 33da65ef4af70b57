"""No two files import each other, not even for their types: each can be read after those below it."""

from __future__ import annotations

import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Iterator

import pytest
from python_sources import dotted_imports, folder_of, python_nodes

ROOT = Path(__file__).resolve().parents[2]
LIBRARIES = sorted(path.parent for path in ROOT.glob("src/**/src/*/__init__.py")) + sorted(
    path.parent for path in ROOT.glob("src/**/ros/*/__init__.py")
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
    for name in dotted_imports(path):
        yield from {name if name in modules else name.rpartition(".")[0]} & modules.keys()


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


# -- the picture: which package may import which ------------------------------------------------------------

HELPERS = frozenset(
    {
        "flight_basics",
        "flight_limits",
        "input_checks",
        "input_schemas",
        "kernel_cache",
        "mesh_files",
        "node_tools",
        "stamp_pairing",
    }
)
MAY_IMPORT: dict[str, frozenset[str]] = {
    **dict.fromkeys(HELPERS, frozenset()),
    "flight_basics": frozenset({"node_tools", "stamp_pairing"}),
    "flight_limits": frozenset({"input_schemas"}),
    "mesh_files": frozenset({"input_schemas"}),
    "input_checks": frozenset({"node_tools"}),
    **dict.fromkeys(("simulation_tools", "inspection_tools", "cepa", "gridslam", "exploration"), HELPERS),
    "inspection": HELPERS | {"exploration"},
}
MAY_IMPORT["flights"] = frozenset(MAY_IMPORT)
MAY_IMPORT["doctor"] = HELPERS | {"flights"}
MAY_IMPORT["master_thesis"] = frozenset(MAY_IMPORT) - {"doctor"}
"""By package: those that its library, its ROS side and its nodes may import. Messages anybody may import."""
MESSAGES = re.compile(r"\w+\.(msg|srv|cfg)\b")


def packages_in(path: Path) -> set[str]:
    """Return the packages of the workspace that a file imports, but for their messages."""
    names = {name for name in dotted_imports(path) if not MESSAGES.match(name)}
    return {name.split(".")[0].removesuffix("_ros") for name in names} & MAY_IMPORT.keys()


def test_the_picture_shows_every_package():
    assert MAY_IMPORT.keys() == {path.parent.name for path in ROOT.glob("src/**/setup.py")}


@pytest.mark.parametrize("package", sorted(MAY_IMPORT))
def test_a_package_imports_those_below_it_only(package):
    folder = folder_of(package)
    sources = (*python_nodes(folder), *folder.glob("src/**/*.py"), *folder.glob("ros/**/*.py"))
    allowed = {*MAY_IMPORT[package], package}
    assert {str(path): above for path in sources if (above := packages_in(path) - allowed)} == {}


@pytest.mark.parametrize("package", sorted(MAY_IMPORT.keys() - {"master_thesis"}))
def test_what_a_package_starts_needs_no_experiment(package):
    """Neither a launch file nor a `python -m`: nobody needs master_thesis, which is chapter 8 alone."""
    folder = folder_of(package)
    launched = [*folder.glob("launch/**/*.launch"), *folder.glob("src/**/*.py"), *folder.glob("ros/**/*.py")]
    needs = re.compile(r"find master_thesis|pkg=\"master_thesis|[\"']master_thesis(_ros)?[.\"']")
    found = {str(path): needs.findall(path.read_text(encoding="utf-8")) for path in launched}
    own = {"doctor/drawing.py", "results/picture_files.py"}  # a colour for its nodes, and a salt
    assert {path for path, names in found.items() if names and not path.endswith(tuple(own))} == set()


def test_no_packages_import_each_other_in_a_circle():
    TopologicalSorter(MAY_IMPORT).prepare()


def test_an_import_of_a_package_above_is_seen_and_one_of_messages_is_not(tmp_path):
    source = tmp_path / "node.py"
    source.write_text(
        "from inspection_ros.files import a\nfrom exploration.msg import B\nimport gridslam.volume\n"
    )
    assert packages_in(source) == {"inspection", "gridslam"}
