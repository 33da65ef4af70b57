"""The page of an inspection names each file that the inspection itself writes."""

import re
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
WRITERS = [
    *(PACKAGE / "src/flights/inspecting").glob("*.py"),
    *(PACKAGE / "ros/flights_ros/inspecting").glob("*.py"),
    PACKAGE / "ros/flights_ros/drivers/volume_files.py",
]
FILE = re.compile(r"""["'](\w+\.(?:json|yaml|html|glb|png|bt|ot|state))["']""")


def test_the_page_names_each_file_that_an_inspection_writes():
    read = {path.name for path in (PACKAGE / "config").iterdir()}
    written = {name for path in WRITERS for name in FILE.findall(path.read_text(encoding="utf-8"))} - read
    assert {"plan.yaml", "findings.json", "drawing.glb"} <= written  # the pattern finds what is written
    page = (PACKAGE / "doc/inspection.md").read_text(encoding="utf-8")
    assert {name for name in written if f"`{name}`" not in page} == set()
