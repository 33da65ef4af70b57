"""What the nodes' classes call while they hold a lock. Read from the sources, by names alone.

A call is followed into methods of the same object, and of objects whose class is known by
`self._x = Class(...)`.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass, field
from pathlib import Path
from typing import Iterator

LOCKS = {"Lock", "RLock", "Condition"}


@dataclass
class NodeClass:
    """A class: its methods, and what its attributes are made of.

    made_by: by attribute, the last name of the call that made it. locks: attributes that are locks.
    """

    path: Path
    name: str
    methods: dict[str, ast.FunctionDef]
    made_by: dict[str, str] = field(default_factory=dict)
    locks: set[str] = field(default_factory=set)


def dotted(expression: ast.expr) -> str:
    """Write a name such as self._lock; "?" stands for what is no name."""
    if isinstance(expression, ast.Attribute):
        return f"{dotted(expression.value)}.{expression.attr}"
    return expression.id if isinstance(expression, ast.Name) else "?"


def classes_in(path: Path) -> Iterator[NodeClass]:
    """Yield the classes of a file."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), str(path))):
        if not isinstance(node, ast.ClassDef):
            continue
        methods = {each.name: each for each in node.body if isinstance(each, ast.FunctionDef)}
        found = NodeClass(path, node.name, methods)
        for method in methods.values():
            kinds = {arg.arg: ast.unparse(arg.annotation) for arg in method.args.args if arg.annotation}
            for targets, value in _assignments(method):
                for name in targets:
                    _note(found, name, value, kinds)
        yield found


def _assignments(method: ast.FunctionDef) -> Iterator[tuple[list[str], ast.expr]]:
    """Yield what is given to attributes of `self`: their names, and one value for each."""
    for node in ast.walk(method):
        if isinstance(node, ast.AnnAssign) and node.value is not None:
            pairs = [(node.target, node.value)]
        elif isinstance(node, ast.Assign):
            pairs = [(target, node.value) for target in node.targets]
        else:
            continue
        for target, value in pairs:
            both_are_tuples = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)
            each = zip(target.elts, value.elts) if both_are_tuples else [(target, value)]
            for one, given in each:
                if dotted(one).startswith("self.") and dotted(one).count(".") == 1:
                    yield [dotted(one).removeprefix("self.")], given


def _note(found: NodeClass, name: str, value: ast.expr, kinds: dict[str, str]) -> None:
    if isinstance(value, ast.Call):
        found.made_by[name] = dotted(value.func).rpartition(".")[2]
    kind = kinds.get(value.id, "") if isinstance(value, ast.Name) else ""
    is_lock = found.made_by.get(name) in LOCKS or kind.rpartition(".")[2] in LOCKS
    if is_lock or dotted(value).rpartition(".")[2].endswith("lock"):
        found.locks.add(name)


@dataclass(frozen=True)
class LockedCall:
    """A call under a lock. where: file, class and method that hold it. line: of the call."""

    where: str
    line: int
    lock: str
    call: str
    made_by: str
    """What the called object is: the name of its class, if that is known."""


class LockedCalls:
    """Finds calls under locks in some classes."""

    def __init__(self, classes: list[NodeClass]) -> None:
        self._by_name = {each.name: each for each in classes}

    def of(self, owner: NodeClass) -> list[LockedCall]:
        """Return the calls of a class while it holds a lock."""
        found = []
        for method in owner.methods.values():
            where = f"{owner.path.name}: {owner.name}.{method.name}"
            for block in ast.walk(method):
                if isinstance(block, ast.With):
                    for lock in self._locks_of(owner, block):
                        found += self._calls(owner, block.body, where, lock, set())
        return found

    def _locks_of(self, owner: NodeClass, block: ast.With) -> list[str]:
        names = [dotted(item.context_expr) for item in block.items]
        return [name for name in names if name.rpartition(".")[2] in owner.locks or name.endswith("lock")]

    def _calls(
        self, owner: NodeClass, body: list[ast.stmt], where: str, lock: str, seen: set[str]
    ) -> list[LockedCall]:
        found = []
        for node in (each for statement in body for each in _now(statement)):
            if not isinstance(node, ast.Call):
                continue
            call = dotted(node.func)
            parts, made_by = call.split("."), ""
            target: tuple[NodeClass, str] | None = None
            if parts[0] == "self" and len(parts) == 2 and parts[1] in owner.methods:
                target = owner, parts[1]
            elif parts[0] == "self" and len(parts) >= 2:
                made_by = owner.made_by.get(parts[1], "")
                known = self._by_name.get(made_by)
                if known is not None and len(parts) == 3 and parts[2] in known.methods:
                    target = known, parts[2]
            found.append(LockedCall(where, node.lineno, lock, call, made_by))
            if target is not None and (key := f"{target[0].name}.{target[1]}") not in seen:
                seen.add(key)
                found += self._calls(target[0], target[0].methods[target[1]].body, where, lock, seen)
        return found


def _now(node: ast.AST) -> Iterator[ast.AST]:
    """Walk over what is done now: the bodies of functions that are only defined here are done later."""
    yield node
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, (ast.FunctionDef, ast.Lambda)):
            yield from _now(child)
