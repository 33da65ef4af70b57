"""The reference page of a package tells every topic and parameter that the docstrings of its nodes list."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NAMES = re.compile(r"^    ([a-z~][a-z_/~, ]*) \(", re.MULTILINE)


def listed(node: Path) -> list[str]:
    """Return the names before a bracket, one or several with commas, in the lists of a node's docstrings."""
    classes = [part for part in ast.parse(node.read_text()).body if isinstance(part, ast.ClassDef)]
    text = "\n".join(ast.get_docstring(part) or "" for part in classes)
    names = [name.strip() for found in NAMES.findall(text) for name in found.split(",")]
    return [name for name in names if " " not in name]


def section(node: Path, heading: str | None = None) -> str:
    """Return what the reference page says under the node's name, or another heading; empty if it has none."""
    page = node.parents[1] / "doc/reference.md"
    text = "\n" + page.read_text() if page.exists() else ""
    return text.partition(f"\n## {heading or node.name}\n")[2].partition("\n## ")[0]


def words_of_code(text: str) -> set[str]:
    return {word for code in re.findall(r"`[^`\n]+`", text) for word in re.findall(r"[a-z_]+", code)}


NODES = [
    node for node in sorted(ROOT.glob("src/**/nodes/*")) if node.is_file() and section(node) and listed(node)
]


def test_there_are_nodes_to_compare():
    assert {"cepa", "yaw_regulator", "position_controller", "explore"} <= {node.name for node in NODES}


@pytest.mark.parametrize("node", NODES, ids=lambda node: node.name)
def test_the_page_tells_the_names_of_the_docstring(node):
    told = words_of_code(section(node) + section(node, "Parameters"))
    assert [name for name in listed(node) if not set(re.findall(r"[a-z_]+", name)) <= told] == []
