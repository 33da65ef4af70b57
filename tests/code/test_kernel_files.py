"""numba's cache looks at a kernel's own file only, so a kernel of one file calls none of another.

`gridslam` is the exception: its `stale_code` throws the cache away when any of its files changes.
"""

from __future__ import annotations

import ast
import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core.caching import IndexDataCacheFile

ROOT = Path(__file__).resolve().parents[2]
GUARDED = ROOT / "src/gridslam/src/gridslam/kernels"
FILES = [path for path in sorted(ROOT.glob("src/*/src/**/*.py")) if GUARDED not in path.parents]


def kernels_in(tree: ast.Module) -> list[ast.FunctionDef]:
    """The functions that numba compiles."""
    functions = (node for node in tree.body if isinstance(node, ast.FunctionDef))
    return [node for node in functions if any("njit" in ast.dump(each) for each in node.decorator_list)]


WITH_KERNELS = [path for path in FILES if "@njit" in path.read_text(encoding="utf-8")]


@pytest.mark.parametrize("path", WITH_KERNELS, ids=lambda path: str(path.relative_to(ROOT / "src")))
def test_kernels_use_nothing_of_ours_from_another_file(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    ours = {package.name for package in (ROOT / "src").iterdir()}
    imported = {
        alias.asname or alias.name
        for node in tree.body
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in ours
        for alias in node.names
    }
    for kernel in kernels_in(tree):
        used = {
            name.id for statement in kernel.body for name in ast.walk(statement) if isinstance(name, ast.Name)
        }
        assert not used & imported, f"{kernel.name} uses {sorted(used & imported)} of another file"


def test_there_are_files_to_look_at():
    assert len(WITH_KERNELS) > 5


@pytest.mark.parametrize("module", ["cepa.kernels", "gridslam.kernels", "simulation_tools.kernel_cache"])
def test_processes_that_compile_at_the_same_time_never_mix_their_code(module, tmp_path, monkeypatch):
    with monkeypatch.context() as patch:  # numba as it comes
        patch.setattr(IndexDataCacheFile, "_data_name", counted)
        assert code_for_int(tmp_path / "numba") == "code for float"
        importlib.reload(importlib.import_module(module))
        assert code_for_int(tmp_path / "ours") == "code for int"


def counted(file: IndexDataCacheFile, number: int) -> str:
    return file._data_name_pattern.format(number=number)


def code_for_int(folder: Path) -> str | None:
    """What the cache holds for an int after two processes have compiled a kernel for an int and a float."""
    folder.mkdir()
    one, other = (IndexDataCacheFile(str(folder), "kernel", "stamp") for _ in range(2))
    one._load_index = other._load_index = dict  # both looked before the other wrote
    write = one._save_data
    # The second process writes index and code after the first wrote its index, and before its code
    one._save_data = lambda name, code: (other.save("int", "code for int"), write(name, code))
    one.save("float", "code for float")
    return IndexDataCacheFile(str(folder), "kernel", "stamp").load("int")


UNCALLED = """
import runpy, sys
for package in sys.argv[1:]:
    runpy.run_module(f"{package}.warm_up", run_name="__main__")
    modules = [module for name, module in sys.modules.items() if name.startswith(package)]
    kernels = [pair for module in modules for pair in vars(module).items() if hasattr(pair[1], "py_func")]
    by_others = {name for _, kernel in kernels for name in kernel.py_func.__code__.co_names}
    uncalled = {name for name, kernel in kernels if not kernel.signatures}
    print(package, "does not call", sorted(uncalled - by_others))
"""


def test_every_kernel_is_called_by_the_warm_up():
    """Or it would be compiled in flight."""
    packages = ["cepa", "gridslam", "simulation_tools"]
    paths = os.pathsep.join(str(ROOT / "src" / package / "src") for package in packages)
    command = [sys.executable, "-c", UNCALLED, *packages]
    environment = {**os.environ, "PYTHONPATH": paths}
    told = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=120)
    found = [line for line in told.stdout.splitlines() if "does not call" in line]
    assert found == [f"{package} does not call []" for package in packages]
