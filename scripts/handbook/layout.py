"""What a page gets only in the site: captions of pictures, and commands that fit their box."""

from __future__ import annotations

import re

from handbook.pages import FENCE, prose_lines

FIGURE = re.compile(r"!\[([^\]]+)\]\(([^)\s]+)\)")
"""A picture that is a line of its own."""
COMMENTED = re.compile(r"(\S.*?)\s{2,}# (.*)")
"""A command, and what it does."""
LONGEST_COMMAND = 84
"""Characters that fit beside the menu in a window of 1280 px."""


def with_captions(text: str) -> str:
    """Return a page with its words below each picture, which opens in its own size when it is clicked."""
    lines = []
    for is_prose, line in prose_lines(text):
        figure = FIGURE.fullmatch(line) if is_prose else None
        if figure is not None:
            words, file = figure.groups()
            line = f"[![{words}]({file})]({file})\n\n{words}\n{{: .caption }}\n"
        lines.append(f"{line}\n")
    return "".join(lines)


def with_comments_above(text: str) -> str:
    """Return a page whose commands have their comments in a line above, where one of a block is too long."""
    lines: list[str] = []
    block: list[str] | None = None
    for line in text.splitlines():
        if block is None:
            lines.append(line)
            block = [] if re.fullmatch(r"```(sh|bash)", line) else None
        elif FENCE.match(line):
            is_long = any(len(each) > LONGEST_COMMAND and COMMENTED.fullmatch(each) for each in block)
            lines += [*(_comments_above(block) if is_long else block), line]
            block = None
        else:
            block.append(line)
    return "".join(f"{line}\n" for line in [*lines, *(block or ())])


def _comments_above(block: list[str]) -> list[str]:
    lines: list[str] = []
    for before, line in zip(["", *block], block):
        parts = None if before.endswith("\\") else COMMENTED.fullmatch(line)
        lines += [line] if parts is None else [f"# {parts[2]}", parts[1]]
    return lines
