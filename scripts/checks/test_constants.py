"""Every number of cepa's algorithm dynamic stands in one table, with its unit, its source and its effect."""

from __future__ import annotations

import ast
import importlib.util
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
_spec = importlib.util.spec_from_file_location("constants_page", ROOT / "scripts/constants_page.py")
constants_page = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(constants_page)

MODULES = sorted(constants_page.FOLDER.glob("[a-z]*.py"))
ELSEWHERE = [
    path for path in constants_page.DYNAMIC.rglob("*.py") if constants_page.FOLDER not in path.parents
]
LAYOUT = {
    *("ANGLE_ERROR_RAD", "LEAST_M", "LEAST_HORIZONTAL_M", "FIXED", "ROUNDING", "BLOCK"),  # of arithmetic
    *(
        "POSITION",
        "ACCELERATION_MAX",
        "NOT_CUT",
        "BITS",
        "LANES",
        "BY_REACH",
        "NOBODY",
        "REMOVED",
        "GIVEN_UP_UNTIL",
    ),
}
"""Numbers that may stand elsewhere: places in rows, bits and marks, which nobody tunes."""


def numbers_in(path):
    """Return the names of a module's own numbers; of several in one line, the first."""
    found = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign):
            parts = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
            literals = [part.operand if isinstance(part, ast.UnaryOp) else part for part in parts]
            if all(isinstance(part, ast.Constant) and not isinstance(part.value, str) for part in literals):
                found.add(ast.unparse(node.targets[0]).strip("()").split(",")[0])
    return found


def test_the_page_shows_what_the_code_says():
    assert constants_page.PAGE.read_text(encoding="utf-8") == constants_page.page(), (
        "run scripts/constants_page.py"
    )


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_every_constant_tells_unit_source_and_effect(path):
    told = constants_page.constants_in(path)
    assert {constant.name for constant in told} >= numbers_in(path)
    assert len(told) >= 6


def test_no_name_stands_for_two_numbers():
    names = Counter(constant.name for path in MODULES for constant in constants_page.constants_in(path))
    assert len(names) > 140
    assert [name for name, count in names.items() if count > 1] == []


def test_no_number_stands_elsewhere():
    found = {path.stem: numbers_in(path) - LAYOUT for path in ELSEWHERE}
    assert len(found) > 50
    assert {stem: names for stem, names in found.items() if names} == {}


@pytest.mark.parametrize(
    "docstring",
    [
        "",
        '"""m: How far. Greater: farther."""',
        '"""m: How far. Source: guessed. Greater: farther."""',
        '"""How far. Source: chosen. Greater: farther."""',
    ],
)
def test_a_constant_without_them_is_refused(tmp_path, docstring):
    path = tmp_path / "some.py"
    path.write_text(f"REACH_M = 1.0\n{docstring}\n", encoding="utf-8")
    with pytest.raises(ValueError, match="REACH_M"):
        constants_page.constants_in(path)
