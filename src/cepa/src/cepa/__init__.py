"""Cushioned Extended-Periphery Avoidance (CEPA), after chapter 6 of the thesis. See README.md.

The library is imported when one of its names is first asked for. So who needs `cepa.parameters` alone, as
the check of a launch, does not wait for numba, which takes a quarter of a second.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cepa.library import *  # noqa: F403
else:

    def __getattr__(name):
        if name.startswith("_") or find_spec(f"cepa.{name}"):  # Python imports modules by itself
            raise AttributeError(f"module cepa has no attribute {name}")
        return getattr(import_module("cepa.library"), name)
