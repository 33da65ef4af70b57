"""Lets the library's tests run where the workspace is not built, and with its generated cfg where it is."""

import sys
from pathlib import Path

SOURCE = str(Path(__file__).resolve().parents[1] / "src")

try:
    import exploration.cfg  # noqa: F401  the built workspace, sourced
except ImportError:
    sys.modules.pop("exploration", None)
    sys.path.insert(0, SOURCE)

sys.path.insert(0, str(Path(__file__).resolve().parent))  # helpers of the tests
