"""A limit of a parameter stands in its field (`limited`), from where check, pages and .cfg files take it."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Iterator

ROOT = Path(__file__).resolve().parents[2]
MEASURED = "what a sensor or a state file tells is no parameter"
BY_HAND = {
    "SurveyParameters": "spacing is 0 or at least 0.1; margin's limit is a share of the radius",
    "PaddingParameters": "value is a word, or a number that may be a text",
    "Thresholds": "each of the two limits bounds the other, and one sentence names both",
    "Motion": MEASURED,
    "Cloud": MEASURED,
    "Ranging": MEASURED,
    "PlanarScan": MEASURED,
    "ScanGeometry": MEASURED,
    "OccupancyGrid": MEASURED,
    "MonitorState": MEASURED,
    "UsualMotionState": MEASURED,
}
"""Classes that compare a number with a constant themselves, and why.

The parts of a tuple (a place, a lens, a lidar's elevations) are no fields, and are compared by hand, too.
"""


def compared(source: str) -> Iterator[str]:
    """Yield each class whose `__post_init__` compares an own field with a number."""
    for each in ast.walk(ast.parse(source)):
        if isinstance(each, ast.ClassDef):
            for part in each.body:
                is_check = isinstance(part, ast.FunctionDef) and part.name == "__post_init__"
                if is_check and any(map(_checks_by_hand, ast.walk(part))):
                    yield each.name


def _checks_by_hand(node: ast.AST) -> bool:
    if isinstance(node, ast.Compare):
        parts = [node.left, *node.comparators]
        is_size = all(isinstance(each, (ast.Lt, ast.LtE, ast.Gt, ast.GtE)) for each in node.ops)
        return is_size and any(map(_is_own, parts)) and any(map(_is_number, parts))
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("check_number", "check_whole"):
        return any(map(_is_own, node.args))
    return False


def _is_own(node: ast.AST) -> bool:
    """Tell whether it is `self.NAME`, or `getattr(self, ...)`, or the absolute value of one."""
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "abs":
        return _is_own(node.args[0])
    owner = node.value if isinstance(node, ast.Attribute) else None
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "getattr":
        owner = node.args[0]
    return getattr(owner, "id", "") == "self"


def _is_number(node: ast.AST) -> bool:
    value = node.operand if isinstance(node, ast.UnaryOp) else node
    if isinstance(value, ast.Name) and value.id.isupper():
        return True
    return isinstance(value, ast.Constant) and isinstance(value.value, (int, float))


def test_limits_by_hand_are_found():
    body = "class AParameters:\n    def __post_init__(self):\n        "
    for line in (
        "assert 0.0 < self.x < 5",
        "assert self.x > -1.0",
        "assert abs(self.x) <= MOST_M",
        "assert getattr(self, name) >= 0",
        'check_number("x", self.x, 0.0, 1.0)',
    ):
        assert list(compared(body + line)) == ["AParameters"], line
    for line in ("assert self.low < self.high", "assert self.window % 2 == 0", "check_parameters(self)"):
        assert not list(compared(body + line)), line


def test_no_parameter_class_checks_a_limit_that_a_field_can_hold():
    found = {
        name: path
        for path in sorted(ROOT.glob("src/**/*.py"))
        if "/test/" not in str(path)
        if "__post_init__" in (text := path.read_text(encoding="utf-8"))
        for name in compared(text)
    }
    strangers = [f"{found[name].relative_to(ROOT)}: {name}" for name in sorted(found.keys() - BY_HAND)]
    assert not strangers, "give the limits in the fields, with `limited`"
    assert not BY_HAND.keys() - found.keys() - {"PaddingParameters"}, "these compare nothing any more"
