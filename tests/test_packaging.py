"""What catkin installs is what the source tree holds."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SETUPS = sorted(ROOT.glob("src/*/setup.py"))


@pytest.mark.parametrize("setup", SETUPS, ids=lambda path: path.parent.name)
def test_setup_lists_every_python_package(setup):
    (packages,) = (
        node.value
        for node in ast.walk(ast.parse(setup.read_text()))
        if isinstance(node, ast.keyword) and node.arg == "packages"
    )
    there = {
        ".".join(path.parent.relative_to(folder).parts)
        for folder in (setup.parent / "src", setup.parent / "ros")
        for path in folder.glob("**/__init__.py")
    }
    assert set(ast.literal_eval(packages)) == there
