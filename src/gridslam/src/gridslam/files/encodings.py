"""Text files that people and other systems write."""

from __future__ import annotations

import codecs

UTF_16 = codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE
"""Begins of a text as PowerShell's ">" writes it."""


def text_of(content: bytes) -> str:
    """Return the text of a file: UTF-8, UTF-16 with its mark, or Latin-1, which every byte is."""
    try:
        return content.decode("utf-16" if content.startswith(UTF_16) else "utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")  # only comments and names hold other than ASCII
