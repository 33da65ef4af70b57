"""What the photographs of a survey are searched for while it is flown."""

from __future__ import annotations

from typing import NamedTuple


class Wanted(NamedTuple):
    """open: photographs of what no photograph shows well enough. cracks: nearer ones of cracks."""

    open: bool = True
    cracks: bool = True
