"""All kernels are compiled through `kernel_cache`, from sources that it knows, and ahead of a flight."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from python_sources import sources

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ["cepa", "gridslam", "exploration", "inspection", "simulation_tools"]
COMPILER = ROOT / "src/helpers/kernel_cache/src/kernel_cache/compiler.py"


def test_kernels_are_compiled_through_the_cache_that_knows_their_sources():
    texts = {path: path.read_text(encoding="utf-8") for path in sources("src")}
    assert "numba.njit(" in texts.pop(COMPILER)
    with_kernels = {path: text for path, text in texts.items() if "njit(" in text}
    assert len(with_kernels) > 30
    own = re.compile(r"^(import|from) numba\b.*\b(njit|jit|vectorize|cfunc)\b|numba\.\w*jit", re.M)
    for path, text in with_kernels.items():
        assert "from kernel_cache.compiler import njit\n" in text, path
        assert not own.search(text), path


LOOK = """
import inspect, runpy, sys
from pathlib import Path
from kernel_cache.sources import sources_of

def file_of(thing):
    return Path(inspect.getfile(thing)).resolve()

def used(kernel):
    names = kernel.py_func.__code__.co_names
    known = [kernel.py_func.__globals__[name] for name in names if name in kernel.py_func.__globals__]
    yield from (other.py_func for other in known if hasattr(other, "py_func"))
    for types in kernel.signatures:
        yield from (each.instance_class for each in types if hasattr(each, "instance_class"))

for package in sys.argv[1:]:
    runpy.run_module(f"{package}.warm_up", run_name="__main__")
    modules = [module for name, module in sys.modules.items() if name.startswith(package)]
    kernels = [pair for module in modules for pair in vars(module).items() if hasattr(pair[1], "py_func")]
    by_others = {name for _, kernel in kernels for name in kernel.py_func.__code__.co_names}
    uncalled = {name for name, kernel in kernels if not kernel.signatures}
    print(package, "does not call", sorted(uncalled - by_others))
    pairs = {(file_of(kernel.py_func), file_of(thing)) for _, kernel in kernels for thing in used(kernel)}
    others = {(file, other) for file, other in pairs if other != file}
    unknown = sorted((file.stem, other.stem) for file, other in others if other not in sources_of(file))
    print(package, "uses", len(others), "of other files, and does not know", unknown)
"""


@pytest.mark.long
def test_the_warm_up_calls_every_kernel_and_sources_hold_all_it_uses():
    """Or it would be compiled in flight, or fly with the code of older sources."""
    paths = os.pathsep.join(str(path) for path in ROOT.glob("src/**/src"))
    command = [sys.executable, "-c", LOOK, *PACKAGES]
    environment = {**os.environ, "PYTHONPATH": paths}
    told = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=120)
    called = [line for line in told.stdout.splitlines() if "does not call" in line]
    assert called == [f"{package} does not call []" for package in PACKAGES]
    known = [line for line in told.stdout.splitlines() if "does not know" in line]
    assert [line.partition("does not know ")[2] for line in known] == ["[]"] * len(PACKAGES)
    uses = [int(re.search(r"uses (\d+) of", line)[1]) for line in known]
    assert uses[0] > 0  # cepa's named tuples of surroundings.py
    assert uses[1] > 5  # gridslam's kernels of other files
    assert uses[3] > 0  # inspection's kernel of exploration's
