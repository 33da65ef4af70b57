"""Which tests a change can touch. What cannot be placed means all of them."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Collection, Iterable, Sequence

from changed_tests.workspace import Workspace, package_of

ROSTESTS = "tests/test_rostests.py"
EVERYTHING = re.compile(
    r"conftest\.py|tests/conftest\.py|bringup\.sh|pyproject\.toml|requirements\.txt|\.ci/.*|\.github/.*|my\.world"
    r"|scripts/(?:setup|console)\.sh|scripts/import_all\.py|scripts/packages/.*|rosinstall|\.catkin_workspace"
    r"|.*\.em|.*/env-hooks/.*"
)
"""What the set-up or each test reads."""
BUILT = re.compile(r".*/(?:CMakeLists\.txt|package\.xml|setup\.py)|.*\.(?:msg|srv|action|cfg)")
"""What the build of a package reads: it concerns the package, and those that need it."""
PAGES = re.compile(
    r".*\.(?:md|rst)|LICENSE|\.gitignore|\.pre-commit-config\.yaml|benchmarks/results/.*|(?:.*/)?doc/.*\.(?:png|svg)"
)
"""What no program reads; the tests of pages and code do."""
_TEST = re.compile(r"(?:src/(?:(?:helpers|extensions)/)?[^/]+/test|tests)/(?:.*/)?test_[^/]*\.py")
_ROSTEST = re.compile(r"src/(?:(?:helpers|extensions)/)?([^/]+)/test/.*\.test")
_ALWAYS = re.compile(r"tests/(?:code|pages)/")
_READS_FOLDERS = re.compile(r"(?:\b[A-Z][A-Z_]{2,}\b|__file__|rootpath)[^\n]*\.(?:r?glob|iterdir)\(")
_PATH_OF_PYTHON = re.compile(r"""ROOT\.glob\((["'])src/\*\*/(?:src|ros)\1\)""")


@dataclass(frozen=True)
class Selection:
    """The tests to run.

    arguments: pytest's; empty if there is nothing to run. everything: why all tests run, or "". left_out: how
    many of how many test files of a package do not run, for those packages where some do not.
    """

    arguments: tuple[str, ...]
    everything: str = ""
    left_out: tuple[tuple[str, int, int], ...] = ()

    def sentence(self) -> str:
        """Say what runs and what not, in one line."""
        if self.everything:
            return f"All tests run: {self.everything}."
        if not self.arguments:
            return "Nothing has changed, so no test runs."
        if not self.left_out:
            return "All tests run: the change can touch each of them."
        parts = [f"{package} {count} of {total}" for package, count, total in self.left_out]
        return f"Left out, because the change cannot touch them (files): {', '.join(parts)}."


def select(workspace: Workspace, changed: Sequence[str], same_code: Collection[str] = ()) -> Selection:
    """Return the tests that a change of these files can touch.

    same_code: those of them in which only comments and docstrings have changed.
    """
    if not changed:
        return Selection(())
    touched: set[str] = set()
    for path in changed:
        if EVERYTHING.fullmatch(path):
            return _all_tests(f"{path} can touch each of them")
        if PAGES.fullmatch(path):
            continue
        touched |= (dependents := _touched_by(workspace, path, path in same_code))
        if not dependents:
            return _all_tests(f"no file names {path}")
    if workspace.unread:
        path, reason = min(workspace.unread.items())
        return _all_tests(f"{path} is no Python ({reason})")
    tests = {path for path in workspace.files if _is_test(path) and (workspace.root / path).is_file()}
    chosen = {path for path in tests if path in touched or _looks_at_all(workspace, path)}
    if ROSTESTS in touched:
        chosen |= {path for path in tests if _ROSTEST.fullmatch(path)}
    chosen.discard(ROSTESTS)
    return Selection(tuple(sorted(map(_argument, chosen))), left_out=_left_out(tests - {ROSTESTS}, chosen))


def _touched_by(workspace: Workspace, path: str, has_same_code: bool) -> set[str]:
    """Return the files that a change of one file concerns; none: it cannot be placed."""
    if has_same_code:
        return workspace.readers(path)
    package = package_of(path)
    dependents = set() if package and BUILT.fullmatch(path) else workspace.dependents(path)
    is_placed = dependents > {path} or workspace.is_python(path) or _is_test(path)
    if is_placed and not BUILT.fullmatch(path):
        return dependents
    return workspace.dependents_of_package(package) if package else set()


def _all_tests(reason: str) -> Selection:
    return Selection(("src", "tests"), everything=reason)


def _is_test(path: str) -> bool:
    return bool(_TEST.fullmatch(path) or _ROSTEST.fullmatch(path))


def _looks_at_all(workspace: Workspace, path: str) -> bool:
    """Whether a test looks at all that lies in a folder of the workspace, which nothing names then."""
    if _ALWAYS.match(path):
        return True
    if not _TEST.fullmatch(path):
        return False
    text = (workspace.root / path).read_text(encoding="utf-8")
    return _READS_FOLDERS.search(_PATH_OF_PYTHON.sub("", text)) is not None


def _argument(path: str) -> str:
    """Return what pytest calls a file of tests, or a rostest."""
    rostest = _ROSTEST.fullmatch(path)
    return f"{ROSTESTS}::test_rostest[{rostest[1]}/{PurePosixPath(path).stem}]" if rostest else path


def _left_out(tests: Iterable[str], chosen: set[str]) -> tuple[tuple[str, int, int], ...]:
    total, runs = Counter(map(_package, tests)), Counter(map(_package, chosen))
    return tuple(
        (name, total[name] - runs[name], total[name]) for name in sorted(total) if runs[name] < total[name]
    )


def _package(path: str) -> str:
    if _ROSTEST.fullmatch(path):
        return "rostests"
    parts = path.split("/")
    if package := package_of(path):
        return package
    return "/".join(parts[:2] if len(parts) > 2 else parts[:1])
