"""Style of pages, change logs, tables, folders and imports: `.venv/bin/python -m pytest scripts/checks`."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "scripts"), str(ROOT / "tests/code")]
