"""What is compiled before the first scan: all, or a kernel would be compiled in flight."""

import subprocess
import sys

CALLED = """
import importlib, pkgutil
import cepa.kernels
from cepa.warm_up import warm_up
warm_up()
for module in pkgutil.iter_modules(cepa.kernels.__path__):
    kernels = vars(importlib.import_module(f"cepa.kernels.{module.name}"))
    for name, kernel in kernels.items():
        if not name.startswith("_") and getattr(kernel, "signatures", True) == []:
            print(name)
"""


def test_every_kernel_is_called_by_the_warm_up():
    told = subprocess.run(
        [sys.executable, "-c", CALLED], capture_output=True, text=True, check=True, timeout=120
    )
    assert told.stdout.split() == []
