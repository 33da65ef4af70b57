"""Makes the workspace's libraries importable from the sources, so that these tests run without a build."""

import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1]

for name in ("master_thesis", "simulation_tools", "inspection_tools", "cepa"):
    source = str(PACKAGE.parent / name / "src")
    if source not in sys.path:
        sys.path.insert(0, source)


@pytest.fixture(scope="session")
def worlds_folder() -> Path:
    return PACKAGE / "worlds"
