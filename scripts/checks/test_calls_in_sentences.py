"""What a sentence of a page calls by ./bringup.sh is a call that it knows, with a benchmark that is there."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    *ROOT.glob("*.md"),
    *(path for folder in ("doc", "benchmarks", "src") for path in (ROOT / folder).rglob("*.md")),
]
CALL = re.compile(r"`\./bringup\.sh ([^`\s]+)(?: ([^`\s]+))?")
SUBCOMMANDS = {"bench", "docs", "report", "setup", "test", "--help", "<launch", "..."}
LAUNCH_FILES = {path.relative_to(ROOT).parts[-3] + "/" + path.name for path in ROOT.glob("src/**/*.launch")}


def is_known(first: str, second: str) -> bool:
    if first == "bench" and re.fullmatch(r"[a-z]\w*", second):
        return (ROOT / f"benchmarks/{second}.py").is_file()
    return first in SUBCOMMANDS or any(each == first or each.endswith(f"/{first}") for each in LAUNCH_FILES)


def test_sentences_name_calls_that_are_there():
    found = {
        (path.relative_to(ROOT).as_posix(), *call)
        for path in PAGES
        for call in CALL.findall(path.read_text(encoding="utf-8"))
    }
    assert len(found) > 30
    assert [each for each in sorted(found) if not is_known(*each[1:])] == []


def test_a_call_that_is_not_there_is_found():
    assert not is_known("--ros-args", "inspection.launch")
    assert not is_known("inspect.launch", "")
    assert not is_known("bench", "nothing")
    assert is_known("bench", "NAME")
