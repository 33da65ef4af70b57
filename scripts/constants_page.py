#!/usr/bin/env python3
"""Write the page of all constants of CEPA's algorithm dynamic, from the docstrings beside them.

usage: constants_page.py

A docstring has the form "unit: meaning. Source: where it is from. Greater: what a greater value does."
"""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Iterator, NamedTuple

ROOT = Path(__file__).resolve().parents[1]
DYNAMIC = ROOT / "src/cepa/src/cepa/dynamic"
FOLDER, TRACKS = DYNAMIC / "constants", DYNAMIC / "obstacle_tracks/tracks.py"
PAGE = ROOT / "src/cepa/doc/constants.md"
FORM = re.compile(r"(?P<unit>[^:]+): (?P<meaning>.+) Source: (?P<source>\w+)\. Greater: (?P<greater>.+)\.")
SOURCES = ("chosen", "flown", "measured", "grid")


class Constant(NamedTuple):
    """A constant, as its docstring tells of it."""

    name: str
    value: str
    unit: str
    meaning: str
    source: str
    greater: str


def constants_in(path: Path) -> list[Constant]:
    """Return the constants of a module, or of its dataclass of parameters.

    Raises ValueError for one without such a docstring.
    """
    found = []
    for body in bodies_of(ast.parse(path.read_text(encoding="utf-8"))):
        for node, following in zip(body, [*body[1:], None]):
            if not isinstance(node, (ast.Assign, ast.AnnAssign)) or node.value is None:
                continue
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            name, value = ast.unparse(target), ast.unparse(default_of(node.value)).replace("math.", "")
            is_text = isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant)
            text = " ".join(str(following.value.value).split()) if is_text else ""  # type: ignore[union-attr]
            told = FORM.fullmatch(text)
            if told is None or told["source"] not in SOURCES:
                raise ValueError(
                    f"{path.name}: the docstring of {name} lacks unit, source or effect: {text!r}."
                )
            found.append(Constant(name, value, *told.group("unit", "meaning", "source", "greater")))
    return found


def default_of(value: ast.expr) -> ast.expr:
    """Return the default of a field that is `limited(default, ...)`, or what else a name is set to."""
    is_limited = isinstance(value, ast.Call) and ast.unparse(value.func) == "limited"
    return value.args[0] if is_limited else value  # type: ignore[attr-defined]


def bodies_of(module: ast.Module) -> Iterator[list[ast.stmt]]:
    """Yield the statements of a module of constants, or those of a module's dataclass of parameters."""
    classes = [node for node in module.body if isinstance(node, ast.ClassDef)]
    if not classes:
        yield module.body
    for node in classes:
        if node.name.endswith("Parameters"):
            yield [part for part in node.body if not isinstance(part, ast.FunctionDef)]


def page() -> str:
    """Return the page, in Markdown."""
    paths = (*sorted(FOLDER.glob("[a-z]*.py")), TRACKS)
    lines = [
        "# The constants of `algorithm:=dynamic`",
        "",
        "These numbers are no parameters. To change one, edit its module and start the node again. What you",
        "can change in flight stands among the [parameters](reference.md#parameters).",
        "",
        "To find a constant, search this page for a word of what it does (`dead end`, `noise`), or choose a",
        "section:",
        "",
        "|section|what its constants decide|constants|",
        "|---|---|---|",
        *(
            f"|[{title_of(path)}](#{anchor_of(path)})|{subject_of(path)}|{len(constants_in(path))}|"
            for path in paths
        ),
        "",
        "The column *source* says where the number is from. *chosen*: by the author, without a measurement",
        "of this number alone. *flown*: flights showed that it is needed ([results](results.md)).",
        "*measured*: it was measured. *grid*: it is the size of a grid or a list.",
        "",
        "`scripts/constants_page.py` writes this page from the modules.",
    ]
    for path in paths:
        name = path.relative_to(DYNAMIC.parent)
        lines += [
            "",
            f"## {title_of(path)}",
            "",
            f"{subject_of(path)} Module: [`{name}`](../src/cepa/{name})",
            "",
            "|constant|value|meaning|source|a greater value|",
            "|---|---|---|---|---|",
        ]
        for constant in constants_in(path):
            unit = "" if constant.unit == "1" else f" {constant.unit}"
            row = (
                f"`{constant.name}`",
                f"{constant.value}{unit}",
                constant.meaning.replace("|", r"\|"),
                constant.source,
                constant.greater,
            )
            lines.append(f"|{'|'.join(row)}|")
    return "\n".join(lines) + "\n"


def title_of(path: Path) -> str:
    """Return the heading of a module's section."""
    return path.stem.replace("_", " ").capitalize()


def anchor_of(path: Path) -> str:
    """Return where a link finds the section."""
    return path.stem.replace("_", "-")


def subject_of(path: Path) -> str:
    """Return the first sentence of a module, without its title."""
    told = (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").split("\n")[0]
    subject = told.partition(": ")[2] or told
    return subject[:1].upper() + subject[1:]


def main() -> None:
    """Write the page."""
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
