"""OBJ as other programs write it: with decimal commas, and with indices that count back from their line."""

from __future__ import annotations

import re

_COMMA = re.compile(r"(?m)^(\s*(?:v|vn|vt|vertex|facet)\s.*\d,\d.*)$")
_BACK = re.compile(r"(?m)^\s*f\s.*-\d")
_COUNTED = ("v", "vt", "vn")


def with_points(text: str) -> str:
    """Return the text of an OBJ or an STL with decimal points, if it has decimal commas."""
    return _COMMA.sub(lambda line: line[1].replace(",", "."), text)


def with_own_indices(text: str) -> str:
    """Return the text of an OBJ whose faces count their corners from the file's beginning.

    -1 is the last vertex before the face, not the last one of the file.
    """
    if not _BACK.search(text):
        return text
    counts, lines = dict.fromkeys(_COUNTED, 0), []
    for line in text.splitlines():
        key, *words = line.split() or [""]
        if key in counts:
            counts[key] += 1
        elif key == "f":
            line = " ".join(["f", *(_corner(word, counts) for word in words)])
        lines.append(line)
    return "\n".join(lines)


def _corner(word: str, counts: dict[str, int]) -> str:
    """Return a corner's indices of vertex, texture and normal."""
    indices = []
    for index, kind in zip(word.split("/"), _COUNTED):
        indices.append(str(counts[kind] + 1 + int(index)) if index.startswith("-") else index)
    return "/".join(indices)
