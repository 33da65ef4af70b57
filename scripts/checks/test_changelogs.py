"""Each package's CHANGELOG.rst is as REP-132 wants; the page for users tells the same releases, shortly."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = sorted(path.parent for path in ROOT.glob("src/**/package.xml"))
LINES_MAX = 30
"""Of a release on the page for users."""


def version(package: Path) -> str:
    return re.search(r"<version>(.*)</version>", (package / "package.xml").read_text()).group(1)


def changelog(package: Path) -> str:
    return (package / "CHANGELOG.rst").read_text(encoding="utf-8")


def releases() -> dict[str, str]:
    """Return the releases of the page for users: what stands under each heading."""
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    return dict(re.findall(r"^## ([^\n]*)\n(.*?)(?=^## |\Z)", text, re.M | re.S))


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.name)
def test_a_changelog_has_sections_of_bullets(package):
    lines = changelog(package).splitlines()
    title = f"Changelog for package {package.name}"
    assert lines[:3] == ["^" * len(title), title, "^" * len(title)]
    headings = [lines[i - 1] for i, line in enumerate(lines) if line and set(line) == {"-"}]
    assert headings[0] == "Forthcoming" or headings[0].startswith(version(package))
    assert all(re.fullmatch(r"\d+\.\d+\.\d+ \(\d{4}-\d\d-\d\d\)", each) for each in headings[1:])
    rest = [line for line in lines[3:] if line and line not in headings and set(line) != {"-"}]
    assert all(re.match(r"\* \w|\* ``|  \S", line) for line in rest)


def test_each_changelog_waits_for_the_next_release_or_none_does():
    """`catkin_tag_changelog` gives the new version only to those that do, and a release needs all."""
    waits = {package.name: "\nForthcoming\n---" in changelog(package) for package in PACKAGES}
    waits["CHANGELOG.md"] = "Forthcoming" in releases()
    assert len(set(waits.values())) == 1, waits


def test_all_packages_have_one_version():
    assert len({version(path.parent) for path in ROOT.glob("src/**/package.xml")}) == 1


def test_the_page_for_users_tells_the_newest_release_of_every_package():
    newest = next(heading for heading in releases() if heading != "Forthcoming")
    assert newest.split(" ")[0] == version(PACKAGES[0])
    for package in PACKAGES:
        is_new = changelog(package).count("\n---") == 1  # it was in no release yet
        assert is_new or f"\n{newest}\n{'-' * len(newest)}\n" in changelog(package), package.name


def test_a_release_on_the_page_for_users_is_short():
    long = {name: len(text.splitlines()) for name, text in releases().items()}
    assert {name: lines for name, lines in long.items() if lines > LINES_MAX} == {}


def test_a_changelog_tells_of_its_own_nodes():
    """A line that begins with a node's name stands in the package that has the node now."""
    owners = defaultdict(set)
    for path in ROOT.glob("src/**/nodes/*"):
        owners[path.name].add(path.parts[-3])
    shared = {"explore", "inspection"}  # launch files have these names, too
    lost = {
        (package.name, name): owners[name]
        for package in PACKAGES
        for name in re.findall(r"(?m)^\* ``(\w+)``", changelog(package))
        if name not in shared and name in owners and package.name not in owners[name]
    }
    assert lost == {}
