"""Compiles parts of one package's kernels, for `machine_code`: usage compile_parts MODULE:FUNCTION ...

It prints lines of JSON: how many kernels are ready, and how many there are.
"""

from __future__ import annotations

import json
import sys
from importlib import import_module
from typing import Any, Callable, Sequence

from node_tools.compiling import Kernels, counted


def main(parts: Sequence[str]) -> None:
    """Call the functions, and tell the count after each kernel."""
    functions = [_function(part) for part in parts]
    kernels = Kernels(*functions)
    _tell(0, len(kernels))
    with counted(kernels, _tell):
        for function in functions:
            function()
    _tell(len(kernels), len(kernels))


def _function(part: str) -> Callable[[], Any]:
    module, _, name = part.partition(":")
    return getattr(import_module(module), name)


def _tell(ready: int, total: int) -> None:
    print(json.dumps([ready, total]), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
