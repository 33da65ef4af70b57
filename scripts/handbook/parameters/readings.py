"""What a node reads from the parameter server: names and defaults, as its script and ROS side ask."""

from __future__ import annotations

import ast
import re
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Iterator

from handbook.parameters.sources import Module, Sources

UNKNOWN = object()
"""A default that no source tells as a constant."""


@dataclass
class Readings:
    """What one node reads."""

    names: dict[str, Any] = field(default_factory=dict)
    """Default by name, of what is read by itself; `UNKNOWN`, or None if there is none."""
    classes: list[tuple[str, Module, str]] = field(default_factory=list)
    """Dataclasses that are filled from parameters: prefix of the names ("planner/"), module, class."""
    configs: list[str] = field(default_factory=list)
    """The .cfg files whose parameters are live, without the ending."""
    unclear: list[str] = field(default_factory=list)
    """Names that are put together from what only a run tells, with .* for that."""


def readings_of(node: Module, sources: Sources) -> Readings:
    """Return what a node reads, itself and in the modules of its package's ROS side that it imports."""
    found = Readings()
    for module in _reached(node, sources):
        _configs(module, found)
        for scope, call in _calls(module.tree):
            _read(module, scope, call, found)
    return found


def _reached(node: Module, sources: Sources) -> Iterator[Module]:
    """Yield the node and each module of a ROS side that it imports, directly or not."""
    waiting, seen = [node], set()
    while waiting:
        module = waiting.pop()
        if module.path in seen:
            continue
        seen.add(module.path)
        yield module
        for where, what in module.imports.values():
            if where.split(".")[0].endswith("_ros"):
                waiting += [
                    known for known in (sources.module(where), sources.module(f"{where}.{what}")) if known
                ]


def _configs(module: Module, found: Readings) -> None:
    for where, what in module.imports.values():
        if where.endswith(".cfg") and what.endswith("Config"):
            found.configs.append(f"{where.removesuffix('.cfg')}/cfg/{what.removesuffix('Config')}")


def _calls(tree: ast.Module) -> Iterator[tuple[list[ast.AST], ast.Call]]:
    """Yield each call, and what it stands in, outermost first."""

    def walk(node: ast.AST, above: list[ast.AST]) -> Iterator[tuple[list[ast.AST], ast.Call]]:
        if isinstance(node, ast.Call):
            yield above, node
        for child in ast.iter_child_nodes(node):
            yield from walk(child, [*above, node])

    yield from walk(tree, [])


def _read(module: Module, scope: list[ast.AST], call: ast.Call, found: Readings) -> None:
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if name in ("get_param", "get") and call.args:
        keys = _keys(call.args[0], scope)
        for key in keys:
            found.names.setdefault(key, _default(module, call))
        in_reader = any(getattr(each, "name", "") in _readers(module) for each in scope)
        if not keys and not in_reader and isinstance(call.args[0], ast.JoinedStr):
            parts = call.args[0].values
            pattern = "".join(str(part.value) if isinstance(part, ast.Constant) else ".*" for part in parts)
            found.unclear += [pattern[1:]] if pattern.startswith("~") else []
    elif name == "read_parameters" and call.args and isinstance(call.args[0], ast.Name):
        found.classes.append(("", module, call.args[0].id))
    elif name == "read_group" and isinstance(call.args[1], ast.Name):  # read_group("~planner", Class)
        found.classes += [(f"{key}/", module, call.args[1].id) for key in _keys(call.args[0], scope)]
    elif name == "read_values" and call.args:
        with suppress(LookupError):  # cepa's come from its .cfg
            found.names.update(module.value(call.args[0]))
    elif name in _readers(module) and call.args and isinstance(call.args[0], ast.Constant):
        key = _readers(module)[name] + str(call.args[0].value).lstrip("~")
        found.names.setdefault(key, _default(module, call))


def _default(module: Module, call: ast.Call) -> Any:
    if len(call.args) < 2:
        return None
    try:
        return module.value(call.args[1])
    except LookupError:
        return UNKNOWN


def _keys(argument: ast.expr, scope: list[ast.AST]) -> list[str]:
    """Return the private names that an argument of get_param stands for."""
    if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
        return [argument.value[1:]] if argument.value.startswith("~") and len(argument.value) > 1 else []
    if isinstance(argument, ast.JoinedStr) and isinstance(argument.values[0], ast.Constant):
        start = str(argument.values[0].value)
        inner = getattr(argument.values[1], "value", None) if len(argument.values) == 2 else None
        if start.startswith("~") and isinstance(inner, ast.Name):
            return [start[1:] + value for value in _values_of(inner.id, scope)]
    if isinstance(argument, ast.Name):
        return [value[1:] for value in _values_of(argument.id, scope) if value.startswith("~")]
    return []


def _values_of(name: str, scope: list[ast.AST]) -> list[str]:
    """Return the texts that the variable of an enclosing comprehension or loop takes."""
    for node in reversed(scope):
        for loop in [node] if isinstance(node, ast.For) else getattr(node, "generators", []):
            targets = loop.target.elts if isinstance(loop.target, ast.Tuple) else [loop.target]
            series = loop.iter.args if isinstance(loop.iter, ast.Call) else [loop.iter]
            for target, values in zip(targets, series):
                if isinstance(target, ast.Name) and target.id == name:
                    return _texts(values)
    return []


def _texts(values: ast.expr) -> list[str]:
    if isinstance(values, ast.Constant) and isinstance(values.value, str):
        return list(values.value)
    parts = values.elts if isinstance(values, (ast.Tuple, ast.List)) else []
    return [part.value for part in parts if isinstance(part, ast.Constant) and isinstance(part.value, str)]


def _readers(module: Module) -> dict[str, str]:
    """Return the functions that read the parameter of a given name, and what they put before the name."""
    found = {name: "" for name, (_, there) in module.imports.items() if there in ("number", "port")}
    for node in module.tree.body:
        if isinstance(node, ast.FunctionDef) and node.args.args and node.args.args[0].arg == "name":
            text = ast.unparse(node).replace("'", '"')
            start = re.search(r'get_param\((?:f?"~([\w/]*)(?:" \+ name|\{name\}")|name)', text)
            if start:
                found[node.name] = start.group(1) or ""
    return found
