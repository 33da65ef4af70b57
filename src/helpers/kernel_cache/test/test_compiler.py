"""A kernel never flies with the code of older sources, wherever that is kept."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numba
import pytest
from numba.core.caching import IndexDataCacheFile

from kernel_cache import folders, sources

CALLEE = """
from kernel_cache.compiler import njit

@njit(cache=True)
def value():
    return {}
"""
PAIRS = """
from typing import NamedTuple

class Pair(NamedTuple):
    {}: float
    {}: float
"""
NUMBERS = "LIMIT = {}\n"
CALLER = """
from kernel_cache.compiler import njit
from loops.callee import value
from loops.deeper import numbers
from loops.pairs import Pair

LIMIT = numbers.LIMIT

@njit(cache=True)
def ask(pair: Pair):
    return value() + pair.one + LIMIT
"""


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package whose kernel uses another file's kernel, named tuple and constant."""
    folder = tmp_path / "src/loops"
    (folder / "deeper").mkdir(parents=True)
    (folder / "__init__.py").touch()
    (folder / "deeper/__init__.py").touch()
    (folder / "caller.py").write_text(CALLER)
    (folder / "callee.py").write_text(CALLEE.format(10))
    (folder / "pairs.py").write_text(PAIRS.format("one", "other"))
    (folder / "deeper/numbers.py").write_text(NUMBERS.format(1000))
    monkeypatch.syspath_prepend(str(folder.parent))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "users"))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    yield folder
    forget()


@pytest.fixture(params=["beside the sources", "NUMBA_CACHE_DIR", "read-only folder"])
def package_anywhere(request, package, tmp_path, monkeypatch):
    """The package, with its code in one of the places where it may be kept."""
    if request.param == "NUMBA_CACHE_DIR":
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "given"))
    elif request.param == "read-only folder":
        (package / "__pycache__").touch()  # so that no folder can be made, also by root
    return package


def forget():
    """Forget what a process has read."""
    for name in [name for name in sys.modules if name.partition(".")[0] == "loops"]:
        del sys.modules[name]
    for known in (folders.folder_for, sources.digest_of, sources._imported):
        known.cache_clear()
    importlib.invalidate_caches()


def ask():
    """What a new process computes for a pair of 1 and 200, and how much of its code was kept."""
    forget()
    kernel = importlib.import_module("loops.caller").ask
    pair = importlib.import_module("loops.pairs").Pair(one=1.0, other=200.0)
    return kernel(pair), sum(kernel.stats.cache_hits.values())


def test_code_is_kept_while_its_sources_stay(package_anywhere):
    assert ask() == (1011.0, 0)
    assert ask() == (1011.0, 1)
    (package_anywhere / "unused.py").touch()
    assert ask() == (1011.0, 1)


def test_code_that_is_loaded_keeps_no_objects_of_the_compiler_until_another_kernel_needs_them(package):
    ask()
    assert ask() == (1011.0, 1)
    kernel, pair = sys.modules["loops.caller"].ask, sys.modules["loops.pairs"].Pair(1.0, 200.0)
    (loaded,) = (compiled.library for compiled in kernel.overloads.values())
    assert loaded._shared_module is None
    assert numba.njit(lambda pair: kernel(pair) + 1.0)(pair) == 1012.0
    assert loaded._shared_module is not None


@pytest.mark.parametrize(
    ("file", "text", "answer"),
    [
        ("callee.py", CALLEE.format(20), 1021.0),
        ("pairs.py", PAIRS.format("other", "one"), 1011.0),
        ("deeper/numbers.py", NUMBERS.format(3000), 3011.0),
    ],
)
def test_code_is_compiled_anew_when_another_file_changes(package_anywhere, file, text, answer):
    ask()
    (package_anywhere / file).write_text(text)
    assert ask() == (answer, 0)
    assert ask() == (answer, 1)


def test_beside_the_sources_older_code_is_deleted(package):
    ask()
    (package / "callee.py").write_text(CALLEE.format(20))
    ask()
    kept = {folder.name.rpartition("-")[0] for folder in (package / "__pycache__/kernels").iterdir()}
    assert kept == {"caller", "callee"}
    assert len(list((package / "__pycache__/kernels").iterdir())) == 2


def test_code_that_a_build_has_left_in_a_read_only_folder_is_used(package, tmp_path, monkeypatch):
    beside = package / "__pycache__/kernels"
    assert ask() == (1011.0, 0)
    is_writable = folders._is_writable  # root may write everywhere
    monkeypatch.setattr(folders, "_is_writable", lambda at: beside not in at.parents and is_writable(at))
    assert ask() == (1011.0, 1)
    assert str(folders.folder_for(package / "caller.py")).startswith(str(tmp_path / "users"))


def test_without_any_writable_folder_it_computes_all_the_same(package, monkeypatch):
    monkeypatch.setattr(folders, "_is_writable", lambda at: False)
    assert ask() == (1011.0, 0)
    (package / "callee.py").write_text(CALLEE.format(20))
    assert ask() == (1021.0, 0)


def test_whether_a_file_has_code_is_told_of_its_own_kernels(package):
    forget()
    files = [package / name for name in ("caller.py", "callee.py")]
    assert [folders.has_code(file) for file in files] == [False, False]
    importlib.import_module("loops.callee").value()
    assert [folders.has_code(file) for file in files] == [False, True]


def test_imports_of_all_kinds_are_sources(tmp_path):
    package = tmp_path / "ours"
    (package / "sub").mkdir(parents=True)
    texts = {
        "__init__.py": "",
        "a.py": "import numpy\nfrom . import b\nfrom .sub import c\nimport ours.sub.d as d\n",
        "b.py": "from ours.sub.e import (\n    anything,\n)\n",
        "sub/__init__.py": "",
        "sub/c.py": "from .. import a\n",
        "sub/d.py": "def f():\n    from ..g import x\n",
        "sub/e.py": "",
        "g.py": "",
        "h.py": "",
    }
    for name, text in texts.items():
        (package / name).write_text(text)
    found = {str(path.relative_to(package)) for path in sources.sources_of(package / "a.py")}
    assert found == set(texts) - {"h.py"}


def test_processes_that_compile_at_the_same_time_never_mix_their_code(tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(IndexDataCacheFile, "_data_name", counted)  # numba as it comes
        assert code_for_int(tmp_path / "numba") == "code for float"
    assert code_for_int(tmp_path / "ours") == "code for int"


def counted(file: IndexDataCacheFile, number: int) -> str:
    return file._data_name_pattern.format(number=number)


def code_for_int(folder: Path) -> str | None:
    """What the cache holds for an int after two processes have compiled a kernel for an int and a float."""
    importlib.import_module("kernel_cache.compiler")
    folder.mkdir()
    one, other = (IndexDataCacheFile(str(folder), "kernel", "stamp") for _ in range(2))
    one._load_index = other._load_index = dict  # both looked before the other wrote
    write = one._save_data
    # The second process writes index and code after the first wrote its index, and before its code
    one._save_data = lambda name, code: (other.save("int", "code for int"), write(name, code))
    one.save("float", "code for float")
    return IndexDataCacheFile(str(folder), "kernel", "stamp").load("int")
