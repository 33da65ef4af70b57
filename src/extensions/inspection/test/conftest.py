"""Lets the library's tests run where nothing is built, and with the generated messages where it is."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent

try:
    import inspection.msg  # noqa: F401  the built workspace, sourced
except ImportError:
    sys.modules.pop("inspection", None)
    sys.path.insert(0, str(HERE.parent / "src"))

# helpers of the tests, and the drawn voxels of exploration's
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "exploration/test")]
