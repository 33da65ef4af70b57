"""Lists as code hosts read them, written as Python-Markdown reads them."""

from __future__ import annotations

import re

from handbook.pages import prose_lines

ITEM = re.compile(r"( *)((?:[-*+]|\d+[.)]) +)(?=\S)")
STEP = 4
"""Python-Markdown nests by so many spaces; code hosts nest by the width of the item's mark."""


def spread(text: str) -> str:
    """Return a page whose lists are nested by 4 spaces and begin, as tables do, behind an empty line."""
    written: list[str] = []
    open_items: list[int] = []  # where the content of each open item begins, in the page as it was
    before = ""
    for is_prose, line in prose_lines(text):
        content = line.lstrip(" ")
        indent = len(line) - len(content)
        item = ITEM.match(line) if is_prose else None
        continues = bool(before.strip()) and not item and is_prose  # part of the paragraph above
        was_open = bool(open_items)
        if content and not continues:
            while open_items and indent < open_items[-1]:
                open_items.pop()
        depth = len(open_items)
        rest = max(0, indent - (open_items[-1] if open_items else 0))
        begins = (item and not was_open) or (content.startswith("|") and not before.lstrip().startswith("|"))
        if begins and is_prose and before.strip():
            written.append("")
        written.append(" " * (STEP * depth + rest) + content if content else "")
        if item:
            open_items.append(indent + len(item.group(2)))
        before = line
    return "\n".join(written) + "\n"
