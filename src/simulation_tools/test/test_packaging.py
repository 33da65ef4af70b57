"""What catkin installs is what the source tree holds."""

from __future__ import annotations

import ast
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]


def test_setup_lists_every_python_package():
    (packages,) = (
        node.value
        for node in ast.walk(ast.parse((PACKAGE / "setup.py").read_text()))
        if isinstance(node, ast.keyword) and node.arg == "packages"
    )
    there = {
        ".".join(path.parent.relative_to(folder).parts)
        for folder in (PACKAGE / "src", PACKAGE / "ros")
        for path in folder.glob("**/__init__.py")
    }
    assert set(ast.literal_eval(packages)) == there
