"""Lets the whole-workspace tests import the helpers that lie beside them."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path += [str(folder) for folder in sorted(HERE.iterdir()) if folder.is_dir()]
