"""The pages of the workspace, and what they refer to."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Callable, Iterator
from urllib.parse import unquote

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("doc", "benchmarks", "src")
"""Folders whose pages belong to the handbook, beside those of the workspace's own folder."""
FENCE = re.compile(r"^[ ]*(```|~~~)")
LINK = re.compile(r"`[^`]*`|(?<=\]\()([^)\s]+)(?=[^)]*\))")
"""`code`, or where a link leads."""
IMAGE = re.compile(r"!\[([^\]]*)\]\(([^)\s]+)[^)]*\)|<img\s[^>]*>")
CODE = re.compile(r"`[^`]*`")
PICTURES = (".png", ".svg", ".jpg", ".gif", ".webp")


def all_pages(root: Path = ROOT) -> list[Path]:
    """Return the Markdown pages, relative to the workspace."""
    found = [*root.glob("*.md"), *(path for folder in FOLDERS for path in (root / folder).rglob("*.md"))]
    return sorted(path.relative_to(root) for path in found)


def prose_lines(text: str) -> Iterator[tuple[bool, str]]:
    """Yield each line of a page, and whether it is prose: neither in a block of code nor its fence."""
    fence = ""
    for line in text.splitlines():
        mark = FENCE.match(line)
        if mark and (not fence or mark.group(1) == fence):
            fence = "" if fence else mark.group(1)
            yield False, line
        else:
            yield not fence, line


def _without_pictures(code: re.Match[str]) -> str:
    """Return `code` of a line; nothing if it shows how a picture is written."""
    return "" if IMAGE.search(code.group()) else code.group()


def pictures(text: str) -> list[tuple[str, str]]:
    """Return each picture of a page: what it shows, in words, and its file."""
    found = []
    for is_prose, line in prose_lines(text):
        for match in IMAGE.finditer(CODE.sub(_without_pictures, line)) if is_prose else ():
            if match.group(2):
                found.append((match.group(1).strip(), match.group(2)))
            else:
                words, file = (re.search(rf'{name}="([^"]*)"', match.group()) for name in ("alt", "src"))
                found.append((words.group(1).strip() if words else "", file.group(1) if file else ""))
    return found


def without_words(page: Path, root: Path = ROOT) -> list[str]:
    """Return the pictures of a page that have no text."""
    return [file for words, file in pictures((root / page).read_text(encoding="utf-8")) if not words]


def with_links(text: str, change: Callable[[str], str]) -> str:
    """Return a page with each link to a file of the workspace changed; the link's place in the file stays."""

    def changed(match: re.Match[str]) -> str:
        if match.group(1) is None:
            return match.group()
        path, mark, place = match.group(1).partition("#")
        if not path or re.match(r"[a-z]+:", path):
            return match.group(1)
        return change(unquote(path)) + mark + place

    return "".join(
        (LINK.sub(changed, line) if is_prose else line) + "\n" for is_prose, line in prose_lines(text)
    )


def relative(target: Path, page: Path) -> str:
    """Return how a page refers to a file; both are relative to the workspace."""
    return Path(os.path.relpath(target, page.parent)).as_posix()
