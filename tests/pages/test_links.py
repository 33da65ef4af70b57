"""Every relative link, image and anchor in the workspace's pages leads somewhere."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import unquote

import pytest

ROOT = Path(__file__).resolve().parents[2]
ELSEWHERE = {"build", "devel", ".venv", "results", "logs"}
PAGES = sorted(
    path
    for folder in (ROOT, ROOT / "benchmarks", ROOT / "src", ROOT / "doc")
    for path in (folder.glob("*.md") if folder == ROOT else folder.rglob("*.md"))
    if not ELSEWHERE & set(path.relative_to(ROOT).parts)
)
LINK = re.compile(r"\]\(([^)\s]+)[^)]*\)|<(?:img|a)\s[^>]*?(?:src|href)=\"([^\"]+)\"")


def prose(page: Path) -> str:
    """Return a page without its code, in which brackets mean other things."""
    return re.sub(r"^( *)```.*?^\1```|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def links(page: Path) -> list[str]:
    """Return a page's links to files of this workspace and to places in them."""
    found = [first or second for first, second in LINK.findall(prose(page))]
    return [link for link in found if not re.match(r"[a-z]+:", link)]


def anchors(page: Path) -> set[str]:
    """Return the places of a page that can be linked to, as GitHub names them after the headings."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    headings = re.findall(r"^#+ +(.+)$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


def dead(page: Path) -> list[str]:
    """Return those links of a page that lead nowhere."""
    missing = []
    for link in links(page):
        path, _, anchor = unquote(link).partition("#")
        target = (page.parent / path).resolve() if path else page
        if not target.exists() or (anchor and target.suffix == ".md" and anchor not in anchors(target)):
            missing.append(link)
    return missing


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_somewhere(page):
    assert dead(page) == []


def test_a_dead_link_is_found(tmp_path):
    (tmp_path / "other.md").write_text("## A place, *named*\n")
    page = tmp_path / "page.md"
    page.write_text(
        "[ok](other.md) [ok](other.md#a-place-named) ![no](no.png) [no](other.md#nowhere) `[code](none)`\n"
        '<img src="none.png" width="100"> [web](https://example.org) [![no](badge.png)](other.md)\n'
    )
    assert dead(page) == ["no.png", "other.md#nowhere", "none.png", "badge.png"]


def test_all_pages_are_looked_at():
    names = {str(page.relative_to(ROOT)) for page in PAGES}
    assert {
        "README.md",
        "CHANGELOG.md",
        "src/cepa/README.md",
        "src/extensions/flights/doc/tutorial.md",
    } <= names
