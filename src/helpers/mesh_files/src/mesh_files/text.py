"""Mesh files that are text, whatever program and system wrote them."""

from __future__ import annotations

import codecs

MARKS = ((codecs.BOM_UTF8, "utf-8"), (codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be"))
"""Byte order marks."""


def text_of(content: bytes) -> str:
    """Return the text, without a byte order mark and with ends of lines as here.

    Numbers are the same in any code page, so letters that are no UTF-8 do no harm.
    """
    encoding = next((name for mark, name in MARKS if content.startswith(mark)), "utf-8")
    text = content.decode(encoding, errors="replace").removeprefix("\ufeff")
    return text.replace("\r\n", "\n").replace("\r", "\n")
