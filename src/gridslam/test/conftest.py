"""Lets the library's tests, and their helpers, run from the source tree without ROS."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "ros"), str(HERE.parent / "src")]
