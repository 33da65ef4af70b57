"""What launch files tell of the parameters that they set: the `doc` of the argument that is handed on."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Iterator
from xml.etree import ElementTree

from handbook.pages import ROOT

CHOICES = {"$(arg leader)": ("explore", "inspect"), "$(arg driver)": ("exploring", "inspecting")}
"""Nodes that a launch file starts by an argument."""
PACKAGES = {"explore": "exploration", "inspect": "inspection"}
"""Packages of those that have not the launch file's own."""
NODE = tuple[str, str]


def launch_files(root: Path = ROOT) -> list[ElementTree.Element]:
    """Return the launch files of all packages, those that others include last."""
    return [ElementTree.parse(path).getroot() for path in sorted(root.glob("src/**/launch/*.launch"))] + [
        ElementTree.parse(path).getroot() for path in sorted(root.glob("src/**/launch/*/*.launch"))
    ]


def set_by_launch_files(root: Path = ROOT) -> dict[NODE, dict[str, str]]:
    """Return the parameters that launch files set for each node, each with its sentence, or an empty one."""
    files = launch_files(root)
    told: dict[str, str] = {}
    for file in files:
        for arg in file.iter("arg"):
            if arg.get("doc"):
                told.setdefault(str(arg.get("name")), str(arg.get("doc")))
    found: dict[NODE, dict[str, str]] = {}
    for file in files:
        own = {str(arg.get("name")): arg.get("doc", "") for arg in file.findall("arg")}
        for node, name, value in _parameters(file):
            sentence = _told(value, own, told)
            rows = found.setdefault(node, {})
            rows[name] = rows.get(name) or sentence
    return found


def _parameters(file: ElementTree.Element) -> Iterator[tuple[NODE, str, str]]:
    for node in file.iter("node"):
        kind = str(node.get("type"))
        for name in CHOICES.get(kind, (kind,)):
            for parameter in node.findall("param"):
                yield (
                    (PACKAGES.get(name, str(node.get("pkg"))), name),
                    str(parameter.get("name")),
                    str(parameter.get("value", "")),
                )


def _told(value: str, own: dict[str, str], told: dict[str, str]) -> str:
    """Return the sentence of the one argument that a value takes; empty: it takes none, or several."""
    names = set(re.findall(r"\$\(arg (\w+)\)", value))
    if len(names) != 1:
        return ""
    name = names.pop()
    sentence = own.get(name) or told.get(name, "")
    return sentence[:1].upper() + sentence[1:] + "." * (bool(sentence) and sentence[-1] not in ".)")
