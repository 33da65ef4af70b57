"""Counts numba's kernels while they are compiled, to say 12 of 51."""

from __future__ import annotations

import contextlib
import sys
import time
from types import FunctionType, ModuleType
from typing import Any, Callable, Iterator

Tell = Callable[[int, int], None]
"""Is called with the number of kernels that are ready, and with that of all."""
EVERY_S = 5.0
"""Between two words about it, of wall time."""


class Kernels:
    """The kernels that functions may need, by the functions' globals.

    These lead to the modules of the same package that define them, and the globals of those modules to
    others. Of a given function's own module only what it calls counts.
    """

    def __init__(self, *functions: Callable[[], Any]) -> None:
        self._called: dict[Any, set[Any]] = {}  # by each kernel
        for function in functions:
            waiting = list(_kernels_from(function))
            while waiting:
                kernel = waiting.pop()
                if kernel not in self._called:
                    self._called[kernel] = set(_called_by(kernel))
                    waiting.extend(self._called[kernel])

    def __len__(self) -> int:
        return len(self._called)

    def ready(self) -> int:
        """Return how many have machine code. That of a kernel contains those that it calls."""
        ready: set[Any] = set()
        waiting = [kernel for kernel in self._called if kernel.overloads]
        while waiting:
            kernel = waiting.pop()
            if kernel not in ready:
                ready.add(kernel)
                waiting.extend(self._called[kernel])
        return len(ready)


@contextlib.contextmanager
def counted(kernels: Kernels, tell: Tell) -> Iterator[None]:
    """Tell after each kernel that numba compiles how many are ready; what numba has kept is not compiled."""
    from numba.core import event  # takes half a second

    class Listener(event.Listener):
        def on_start(self, event: Any) -> None:
            pass

        def on_end(self, event: Any) -> None:
            tell(kernels.ready(), len(kernels))

    with event.install_listener("numba:compile", Listener()):
        yield


def run_compiled(say: Callable[[str], None], *functions: Callable[[], Any]) -> None:
    """Call functions that run through kernels, and say now and then how many numba had to compile for it."""
    next_s = time.monotonic()

    def tell(ready: int, total: int) -> None:
        nonlocal next_s
        if time.monotonic() >= next_s:
            next_s = time.monotonic() + EVERY_S
            how_many = f": {ready} of {total}" if total else ""  # 0: of other packages
            say(f"Compiling the inner loops, at the first start only{how_many}.")

    with counted(Kernels(*functions), tell):
        for function in functions:
            function()


def _kernels_from(function: Callable[[], Any]) -> Iterator[Any]:
    own = function.__module__
    package = own.partition(".")[0]
    seen: set[Any] = {own}
    waiting: list[Any] = [function]
    while waiting:
        value = waiting.pop()
        if _is_kernel(value):
            yield value
        elif isinstance(value, FunctionType) and value.__module__ == own:
            if value not in seen:
                seen.add(value)
                waiting.extend(_globals_of(value))
        else:
            module = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", None)
            if isinstance(module, str) and module.partition(".")[0] == package and module not in seen:
                seen.add(module)
                waiting.extend(vars(sys.modules[module]).values())


def _called_by(kernel: Any) -> Iterator[Any]:
    for value in _globals_of(kernel.py_func):
        if _is_kernel(value):
            yield value
        elif _is_inlined(value):
            yield from _called_by(value)


def _globals_of(function: FunctionType) -> list[Any]:
    names = function.__code__.co_names
    return [function.__globals__[name] for name in names if name in function.__globals__]


def _is_kernel(value: Any) -> bool:
    return hasattr(value, "py_func") and not _is_inlined(value)


def _is_inlined(value: Any) -> bool:
    """Whether a function becomes part of each kernel that calls it, without machine code of its own."""
    return hasattr(value, "py_func") and value.targetoptions.get("inline") == "always"
