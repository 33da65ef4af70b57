"""Each package's CHANGELOG.rst is read as REP-132 wants, and its versions are the package's."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PACKAGES = sorted(path.parent for path in Path(__file__).resolve().parents[2].glob("src/*/package.xml"))


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.name)
def test_a_changelog_has_sections_of_bullets(package):
    lines = (package / "CHANGELOG.rst").read_text(encoding="utf-8").splitlines()
    title = f"Changelog for package {package.name}"
    assert lines[:3] == ["^" * len(title), title, "^" * len(title)]
    headings = [lines[i - 1] for i, line in enumerate(lines) if line and set(line) == {"-"}]
    version = re.search(r"<version>(.*)</version>", (package / "package.xml").read_text()).group(1)
    assert headings[0] == "Forthcoming" or headings[0].startswith(version)
    rest = [line for line in lines[3:] if line and line not in headings and set(line) != {"-"}]
    assert all(re.match(r"\* \w|  \S", line) for line in rest)
