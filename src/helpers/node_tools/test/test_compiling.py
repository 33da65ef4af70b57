"""Kernels are counted as numba compiles them."""

import importlib
import sys

import pytest

from node_tools.compiling import Kernels, counted, run_compiled

KERNELS = """
from numba import njit

@njit(inline="always")
def inlined(x):
    return called(x) + 1

@njit
def called(x):
    return 2 * x

@njit
def entry(x):
    return inlined(x)

@njit
def never_used_by_thing(x):
    return x
"""
THING = """
from loops_of_a_test.kernels import entry

class Thing:
    def go(self):
        return entry(3)
"""
WARM_UP = """
from loops_of_a_test.thing import Thing
from loops_of_a_test.kernels import never_used_by_thing

def warm_up():
    return _go()

def _go():
    return Thing().go()

def warm_up_other():
    never_used_by_thing(1)
"""


@pytest.fixture
def warm_up_module(tmp_path, monkeypatch):
    package = tmp_path / "loops_of_a_test"
    package.mkdir()
    for name, text in (("__init__", ""), ("kernels", KERNELS), ("thing", THING), ("warm_up", WARM_UP)):
        (package / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield importlib.import_module("loops_of_a_test.warm_up")
    for name in [name for name in sys.modules if name.startswith("loops_of_a_test")]:
        del sys.modules[name]


def test_kernels_behind_classes_and_inlined_functions_count(warm_up_module):
    assert len(Kernels(warm_up_module.warm_up)) == 2  # entry, and called through inlined
    assert len(Kernels(warm_up_module.warm_up_other)) == 1
    assert len(Kernels(warm_up_module.warm_up, warm_up_module.warm_up_other)) == 3


def test_each_kernel_is_told_when_it_is_ready(warm_up_module):
    kernels, told = Kernels(warm_up_module.warm_up), []
    assert kernels.ready() == 0
    with counted(kernels, lambda ready, total: told.append((ready, total))):
        assert warm_up_module.warm_up() == 7
    assert told[-1] == (2, 2)
    assert [ready for ready, _ in told] == sorted(ready for ready, _ in told)
    with counted(kernels, lambda ready, total: pytest.fail("nothing is left to compile")):
        warm_up_module.warm_up()


def test_kernels_that_are_not_known_before_are_told_without_numbers(warm_up_module):
    said = []
    run_compiled(said.append, lambda: warm_up_module.warm_up())  # of another package
    assert set(said) == {"Compiling the inner loops, at the first start only."}
