"""The pages of the libraries: one for each Python package, made by mkdocstrings from the docstrings."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from handbook.pages import ROOT

FOLDER = Path("library")
"""Of these pages, in the site."""
FOUND_LATER = "---\nsearch:\n  boost: 0.001\n---\n"
"""The search shows what a user reads first. A word of a heading counts a thousand times as much as one of a
text, and here each name of the code is a heading. So a heading here counts as much as a text elsewhere."""


def packages(root: Path = ROOT) -> dict[str, Path]:
    """Return the folder of each Python package of the libraries, by the name that Python imports."""
    found = {}
    for init in sorted(root.glob("src/**/src/**/__init__.py")):
        folder = init.parent.relative_to(root)
        found[name_of(folder, root)] = folder
    return found


def name_of(folder: Path, root: Path = ROOT) -> str:
    """Return the Python package of a library in this folder; empty: there is none."""
    inside = re.match(r"src/(?:(?:helpers|extensions)/)?[^/]+/src/(.+)", folder.as_posix())
    return inside[1].replace("/", ".") if inside and (root / folder / "__init__.py").is_file() else ""


def page_of(package: str) -> Path:
    """Return the page of a Python package."""
    return FOLDER / f"{package}.md"


def page(package: str, folder: Path, root: Path = ROOT) -> str:
    """Return the page of a package: what each of its public modules offers."""
    parts = [f"{FOUND_LATER}# {package}\n\n{_docstring(root / folder / '__init__.py')}\n"]
    inner = [
        path.parent
        for path in sorted((root / folder).glob("*/__init__.py"))
        if not path.parent.name.startswith("_")
    ]
    if inner:
        parts.append("\n## Packages in it\n")
    for path in inner:
        name = f"{package}.{path.name}"
        first = _docstring(path / "__init__.py").partition("\n")[0]
        parts.append(f"\n- [{name}]({page_of(name).name}): {first}")
    if inner:
        parts.append("\n")
    for module in sorted((root / folder).glob("*.py")):
        if not module.stem.startswith("_"):
            parts.append(f"\n## {package}.{module.stem}\n\n::: {package}.{module.stem}\n")
    return "".join(parts)


def _docstring(module: Path) -> str:
    return ast.get_docstring(ast.parse(module.read_text(encoding="utf-8"))) or ""
