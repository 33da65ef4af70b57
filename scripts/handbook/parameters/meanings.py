"""What a parameter means: its sentence, unit and limits, from .cfg files and dataclasses."""

from __future__ import annotations

import ast
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator

from handbook.parameters.sources import Module, defaults

UNITS = (
    r"m/s2?/sqrt\(s\)|rad/sqrt\(s\)|m/s\^?[23]|m\^?[23]/s|m/rad|m/s|m\^?[23]|rad/s\^?2|rad/s|rad|deg/s|deg"
    r"|1/s2?|Hz|mm per pixel|mm|px|ms|s|m per m|rad per m|m per rad|rad per rad|m|cd|lux|tesla|degrees|%"
)
BEHIND = (
    "it past where that up for below above per from until ahead kept with within over on to against of near "
    "while by beyond the"
)
"""Words that may follow a unit in a sentence."""
UNIT = re.compile(
    rf"^(?:[\w|, ]*, )?({UNITS})(?:,[^:]*)?:"
    rf"|(?:, in|\bin|,) ({UNITS})(?=[.;,:]|$| (?:{'|'.join(BEHIND.split())})\b)"
)
NAMED = re.compile(r"((?:\w+, )*\w+) \((?:str|bool|int|float|dict|map)\b[^)]*\)")
TYPES = {"double_t": "float", "int_t": "int", "bool_t": "bool", "str_t": "str"}


@dataclass(frozen=True)
class Parameter:
    """A row of the reference."""

    name: str
    kind: str = ""
    default: Any = None
    least: Any = None
    most: Any = None
    sentence: str = ""
    is_live: bool = False
    live: tuple[Any, Any] | None = None
    """Least and greatest value in the .cfg file, where they are not those of the parameter."""

    @property
    def unit(self) -> str:
        """The unit that the sentence tells; empty if there is none."""
        found = UNIT.search(self.sentence)
        return (found.group(1) or found.group(2)) if found else ""


def of_config(path: Path) -> Iterator[Parameter]:
    """Yield the parameters of a .cfg file: add(name, type, level, sentence, default, least, most)."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call) or getattr(node.func, "attr", "") != "add" or len(node.args) < 5:
            continue
        name, kind, _, sentence, *numbers = node.args
        values = [ast.literal_eval(number) for number in numbers]
        default, least, most = [*values, None, None][:3]
        yield Parameter(
            ast.literal_eval(name),
            TYPES[ast.unparse(kind)],
            default,
            least,
            most,
            ast.literal_eval(sentence),
            True,
        )


def of_class(module: Module, node: ast.ClassDef) -> Iterator[Parameter]:
    """Yield the fields of a dataclass, with what its docstring or the text below a field tells of them."""
    told = attributes(ast.get_docstring(node) or "")
    limits = dict(_limits(module, node))
    known = defaults(module, node)
    for part, below in zip(node.body, [*node.body[1:], None]):
        if not isinstance(part, ast.AnnAssign) or not isinstance(part.target, ast.Name):
            continue
        name = part.target.id
        text = told.get(name, "")
        if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant):
            text = " ".join(str(below.value.value).split())
        least, most, live = _limited(module, part.value) or (*limits.get(name, (None, None)), None)
        kind = ast.unparse(part.annotation).split(" | ")[0].split("[")[0]
        yield Parameter(name, kind, known.get(name), least, most, text, live=live)


def attributes(docstring: str) -> dict[str, str]:
    """Return what the section Attributes of a docstring tells, by name; "a, b: ..." is told of both."""
    section = re.search(r"^Attributes:\n(.*?)(?=^\S|\Z)", docstring, re.M | re.S)
    found = {}
    for names, text in re.findall(
        r"^    (\w[\w, ]*?): (.*?)(?=^    \w[\w, ]*?: |\Z)", section.group(1) if section else "", re.M | re.S
    ):
        found.update({name: " ".join(text.split()) for name in names.split(", ")})
    return found


def private_parameters(docstring: str) -> dict[str, str]:
    """Return what a node's docstring tells under "Parameters (private):", as "name (type, default): text"."""
    section = re.search(r"Parameters \(private\):(.*?)(?=\n\s*\n|\Z)", docstring, re.S)
    parts = NAMED.split(" ".join(section.group(1).split()) if section else "")
    found = {}
    for names, text in zip(parts[1::2], parts[2::2]):
        sentence = text.strip(" ;:")
        found.update({name: sentence[:1].upper() + sentence[1:] for name in names.split(", ")})
    return found


def _limits(module: Module, node: ast.ClassDef) -> Iterator[tuple[str, tuple[Any, Any]]]:
    """Yield the limits that `check_number(name, value, least, most)` and its like check."""
    for loop in ast.walk(node):
        names = _texts_of(loop.iter) if isinstance(loop, ast.For) else []
        for call in ast.walk(loop) if isinstance(loop, (ast.For, ast.FunctionDef)) else ():
            if not isinstance(call, ast.Call) or not getattr(call.func, "id", "").startswith("check_"):
                continue
            first = call.args[0]
            checked = [str(first.value)] if isinstance(first, ast.Constant) else names
            bounds = tuple(_number(module, bound) for bound in call.args[2:4])
            if len(bounds) == 2:
                yield from ((name, (bounds[0], bounds[1])) for name in checked)


def _limited(module: Module, value: ast.expr | None) -> tuple[Any, Any, Any] | None:
    """Return least, most and live limits of a field that is `limited(default, least, most)`, else None."""
    if not isinstance(value, ast.Call) or getattr(value.func, "id", "") != "limited":
        return None
    given = dict(zip(("least", "most"), value.args[1:]))
    given.update({str(keyword.arg): keyword.value for keyword in value.keywords})
    found = {name: _number(module, limit) for name, limit in given.items()}
    least, most = found.get("least"), found.get("most")
    if "above" in found:
        least = f"above {shown(found['above'])}"
    if "below" in found:
        most = f"below {shown(found['below'])}"
    return least, most, found.get("live")


def _texts_of(values: ast.expr) -> list[str]:
    parts = values.elts if isinstance(values, (ast.Tuple, ast.List)) else []
    return [str(part.value) for part in parts if isinstance(part, ast.Constant)]


def _number(module: Module, expression: ast.expr) -> Any:
    """Return a limit; one that is another parameter is that one's name."""
    if isinstance(expression, ast.Attribute) and getattr(expression.value, "id", "") == "self":
        return expression.attr
    try:
        return module.value(expression)
    except LookupError:
        return None


def shown(value: Any) -> str:
    """Return a value as a table shows it."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        if math.isinf(value):
            return "none"
        return f"{value:.6g}"
    if isinstance(value, (tuple, list)):
        return " ".join(shown(part) for part in value) or '""'
    return str(value) if value != "" else '""'
