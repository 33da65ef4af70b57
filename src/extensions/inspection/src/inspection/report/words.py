"""Words that several pages and commands use."""

from __future__ import annotations


def counted(number: int, what: str) -> str:
    """Return "1 flight", "2 flights"."""
    return f"{number} {what}" + ("s" if number != 1 else "")
