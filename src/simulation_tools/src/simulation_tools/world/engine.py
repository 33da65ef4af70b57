"""PyBullet, imported without the text that it prints.

On loading, the library writes its build time to C's standard error, which Python cannot redirect.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
from typing import Iterator

from simulation_tools.errors import SimulationToolsError


@contextlib.contextmanager
def _silent_stderr() -> Iterator[None]:
    sys.stderr.flush()
    kept = os.dup(2)
    sink = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(sink, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(sink)


with _silent_stderr():
    import pybullet

__all__ = ["WorldError", "connect", "pybullet"]


class WorldError(SimulationToolsError):
    """The world cannot do what a caller asked for."""


def connect(gui: bool) -> int:
    """Start a new PyBullet client and return its number. gui: with a window; raises WorldError."""
    if gui and not _display_answers():
        raise WorldError(
            "PyBullet cannot open its window: there is no display; set DISPLAY or leave gui off."
        )
    try:
        return pybullet.connect(pybullet.GUI if gui else pybullet.DIRECT)
    except pybullet.error as error:
        raise WorldError(f"PyBullet cannot start: {error}.") from None


def _display_answers() -> bool:
    # Without a display PyBullet ends the whole process, so check first.
    try:
        x11 = ctypes.CDLL("libX11.so.6")
    except OSError:
        return False
    x11.XOpenDisplay.restype = ctypes.c_void_p
    display = x11.XOpenDisplay(None)
    if display:
        x11.XCloseDisplay(ctypes.c_void_p(display))
    return bool(display)
