"""PyBullet, imported without its greeting.

The library writes its build time to the C level's standard error when it is loaded, where no Python
redirection catches it.
"""

from __future__ import annotations

import contextlib
import os
import sys
from typing import Iterator


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

__all__ = ["pybullet"]
