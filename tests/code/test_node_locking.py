"""What a callback publishes, it publishes under the node's lock, which the end of a node waits for.

A node that flies an errand has no lock, and its callbacks publish nothing. Read from the sources: that rospy
closes a topic in just the moment of a publication cannot be had at will.
"""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("inspection_tools", "extensions/exploration", "extensions/inspection")
FILES = sorted(
    path for name in PACKAGES for path in (ROOT / "src" / name / "nodes").iterdir() if path.is_file()
)
TEXTS = {path: path.read_text() for path in FILES}
NODES = [path for path, text in TEXTS.items() if "import rospy" in text and "\nclass " in text]
"""Others are commands."""
ERRANDS = [path for path in NODES if "ErrandServer(" in TEXTS[path]]
"""Their callbacks put messages into an inbox; one thread publishes."""


def dotted(expression) -> str:
    """Write a name such as self._lock."""
    if isinstance(expression, ast.Attribute):
        return f"{dotted(expression.value)}.{expression.attr}"
    return expression.id if isinstance(expression, ast.Name) else "?"


def is_lock(statement) -> bool:
    return isinstance(statement, ast.With) and dotted(statement.items[0].context_expr) == "self._lock"


def unlocked_calls(node):
    """Yield what is called below ``node`` outside of ``with self._lock``."""
    for child in ast.iter_child_nodes(node):
        if is_lock(child):
            continue
        if isinstance(child, ast.Call):
            yield dotted(child.func)
        yield from unlocked_calls(child)


def published_without_lock(method, methods, seen):
    """Yield what a method publishes outside of the lock, by itself or by the node's methods that it calls."""
    for call in unlocked_calls(method):
        if call.endswith(".publish"):
            yield call
        name = call.removeprefix("self.")
        if name in methods and name not in seen:
            seen.add(name)
            yield from published_without_lock(methods[name], methods, seen)


@pytest.mark.parametrize("path", [path for path in NODES if path not in ERRANDS], ids=lambda path: path.name)
def test_callbacks_publish_under_the_lock_only(path):
    nodes = ast.walk(ast.parse(path.read_text()))
    methods = {node.name: node for node in nodes if isinstance(node, ast.FunctionDef)}
    callbacks = [name for name in methods if name.startswith("_on_")]
    assert callbacks
    found = {name: list(published_without_lock(methods[name], methods, {name})) for name in callbacks}
    assert found == {name: [] for name in callbacks}


def test_the_nodes_of_errands_publish_nothing_by_themselves():
    assert sorted(path.name for path in ERRANDS) == ["explore", "inspect", "mission"]
    for path in ERRANDS:
        assert not any(each in TEXTS[path] for each in (".publish(", "threading", "_lock:"))
