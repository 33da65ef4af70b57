"""The compiler's program leaves the memory, and kernels are compiled afterwards as before."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from kernel_cache.compiler_memory import _unchanged_parts, release_compiler

PART = "{} {} 00000000 fe:00 57 {}\nRss:  100 kB\nAnonymous: {} kB\nVmFlags: rd\n"
LIBRARY = "/lib/libllvmlite.so"
PROGRAM = """
import numba, numpy as np
from kernel_cache.compiler_memory import release_compiler

def resident_mb():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) / 1024.0 for line in status if line.startswith("RssFile"))

assert numba.njit(lambda x: x + 1)(1) == 2
before_mb = resident_mb()
release_compiler()
print(before_mb - resident_mb())
assert numba.njit(lambda x: np.sqrt(x))(4.0) == 2.0
"""


def test_only_parts_that_are_as_in_the_file_count():
    text = "".join(
        [
            PART.format("1000-2000", "r-xp", LIBRARY, 0),
            PART.format("2000-3000", "r--p", LIBRARY, 0),
            PART.format("3000-4000", "r--p", LIBRARY, 8),  # the linker has written there
            PART.format("4000-5000", "rw-p", LIBRARY, 0),
            PART.format("5000-6000", "---p", LIBRARY, 0),
            PART.format("6000-7000", "r-xp", "/lib/libc.so.6", 0),
            PART.format("7000-8000", "rw-p", "", 0),
        ]
    )
    assert _unchanged_parts(text) == [(0x1000, 0x2000), (0x2000, 0x3000)]


def test_a_system_that_does_not_tell_its_memory_is_left_alone(tmp_path):
    assert release_compiler(tmp_path / "smaps") == 0


@pytest.mark.skipif(not Path("/proc/self/smaps").exists(), reason="only Linux tells the memory so")
def test_the_compiler_leaves_the_memory_and_compiles_again_later():
    told = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True)
    assert (told.returncode, told.stderr) == (0, "")
    assert float(told.stdout) > 20.0
