"""The pages of the parameters: a table for each node."""

from __future__ import annotations

import ast
import dataclasses
import re
from functools import cache
from pathlib import Path
from typing import Any, Iterator

from handbook.pages import ROOT
from handbook.parameters.launches import set_by_launch_files
from handbook.parameters.meanings import Parameter, of_class, of_config, private_parameters, shown
from handbook.parameters.readings import UNKNOWN, readings_of
from handbook.parameters.sources import Module, Sources

TOLD = ROOT / "doc/parameters.yaml"
"""Sentences of what no .cfg and no dataclass tells of."""
FOLDER = Path("parameters")
"""Of these pages, in the site."""
FOUND_FIRST = "---\nsearch:\n  boost: 4\n---\n"
"""The search shows a parameter before other pages and names of the code, but behind tutorials and how-tos."""
HEAD = "| name | default | unit | what it does | least | greatest | type |\n|---|---|---|---|---|---|---|\n"
NODE = tuple[str, str]
WORDS_MIN = 3
"""A unit alone, or "as x", is no sentence."""


def all_parameters(told: dict[str, Any]) -> dict[NODE, dict[str, Parameter]]:
    """Return the parameters of each node by name. `told` is what doc/parameters.yaml holds."""
    sources, launches = Sources(), set_by_launch_files()
    found = {
        node: _of_node(node, module, sources, told, launches.get(node, {}))
        for node, module in sources.nodes().items()
    }
    return {node: parameters for node, parameters in found.items() if parameters}


def _of_node(
    node: NODE, module: Module, sources: Sources, told: dict[str, Any], launched: dict[str, str]
) -> dict[str, Parameter]:
    own = told.get(node[1], {})
    read = readings_of(module, sources)
    found: dict[str, Parameter] = {}
    classes = [(prefix, *known) for prefix, home, name in read.classes if (known := home.find_class(name))]
    # A YAML map has each key once. So a second class without a prefix stands under " ".
    classes += [(prefix.strip(), *_named(path, sources)) for prefix, path in own.get("classes", {}).items()]
    for prefix, home, filled in classes:
        for parameter in of_class(home, filled):
            if f"{prefix}{parameter.name}/" in {inner for inner, *_ in classes}:
                continue  # the fields of a class in this one have rows of their own
            found[prefix + parameter.name] = dataclasses.replace(parameter, name=prefix + parameter.name)
    for config in read.configs:
        for parameter in of_config(next(ROOT.glob(f"src/**/{config}.cfg"))):
            found[parameter.name] = parameter
    for name, default in read.names.items():
        if f"{name}/" not in {prefix for prefix, *_ in classes}:
            kind = type(default).__name__ if default not in (None, UNKNOWN) else ""
            found.setdefault(name, Parameter(name, kind, None if default is UNKNOWN else default))
    for name, (kind, default, sentence) in own.get("others", {}).items():
        found[name] = Parameter(name, kind, default, sentence=sentence)
    for pattern in read.unclear:
        if not any(re.fullmatch(pattern, name) for name in found):
            found[pattern] = Parameter(pattern)
    written = own.get("written", {})
    for name in [*written, *launched]:
        found.setdefault(name, Parameter(name, "dict" if name in written else ""))
    always = {**own.get("sentences", {}), **written}
    otherwise = {**launched, **told.get("every node", {})}
    for node_class in module.classes.values():
        own_words = private_parameters(ast.get_docstring(node_class) or "")
        otherwise |= {name: text for name, text in own_words.items() if len(text.split()) >= WORDS_MIN}
    return {
        name: dataclasses.replace(
            found[name], sentence=always.get(name) or found[name].sentence or otherwise.get(name, "")
        )
        for name in found
    }


def _named(path: str, sources: Sources) -> tuple[Module, Any]:
    where, _, name = path.rpartition(".")
    module = sources.module(where)
    known = module.find_class(name) if module else None
    if known is None:
        raise LookupError(f"doc/parameters.yaml names {path}, which does not exist.")
    return known


@cache
def _sentences() -> dict[str, Any]:
    import yaml

    return yaml.safe_load(TOLD.read_text(encoding="utf-8"))


def known_parameters() -> dict[NODE, dict[str, Parameter]]:
    """Return the parameters of all nodes, with the sentences of doc/parameters.yaml."""
    return all_parameters(_sentences())


def faults(parameters: dict[NODE, dict[str, Parameter]]) -> list[str]:
    """Return a sentence about each parameter that has none."""
    return [
        f"{package}'s node {node} reads {name}, of which nothing tells: "
        f"give it a sentence in its dataclass, its .cfg or {TOLD.relative_to(ROOT)}."
        for (package, node), rows in parameters.items()
        for name, parameter in rows.items()
        if len(parameter.sentence.split()) < WORDS_MIN
    ]


def pages(parameters: dict[NODE, dict[str, Parameter]]) -> Iterator[tuple[Path, str]]:
    """Yield the page of each package, and its text."""
    for package in sorted({package for package, _ in parameters}):
        text = (
            f"{FOUND_FIRST}# Parameters of {package}\n\nAll are private parameters of their node. "
            "*Live*: it can be changed while the node runs, by dynamic_reconfigure. "
            "`a/b` is `b` in the namespace `a`.\n"
        )
        for (owner, node), rows in parameters.items():
            if owner == package:
                text += f"\n## {node}\n\n{HEAD}{''.join(map(_row, rows.values()))}"
        yield FOLDER / f"{package}.md", text


def _told(parameter: Parameter) -> str:
    """Return what the parameter does. A unit that stands before the sentence has a column of its own."""
    text = parameter.sentence.removeprefix(f"{parameter.unit}: ")
    return text if text == parameter.sentence else text[:1].upper() + text[1:]


def _row(parameter: Parameter) -> str:
    live = " *Live.*" if parameter.is_live else ""
    cells = (
        f"`{parameter.name}`",
        f"`{shown(parameter.default)}`" if parameter.default is not None else "",
        parameter.unit,
        _told(parameter).replace("|", "\\|") + live,
        shown(parameter.least),
        shown(parameter.most),
        parameter.kind,
    )
    return f"| {' | '.join(cells)} |\n"
