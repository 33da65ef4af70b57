"""Prints pytest's arguments for the tests that a change can touch, one a line; on stderr what is left out.

Usage: python -m changed_tests [REF]

The change is what is not committed, and the commits since REF. Without REF: since the branch left origin/main
or main. Nothing on stdout: there is nothing to run.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Sequence

from changed_tests.references import code_of
from changed_tests.selection import select
from changed_tests.workspace import Workspace

ROOT = Path(__file__).resolve().parents[2]
MAIN = ("origin/main", "main")


class GitError(Exception):
    """Git cannot tell the change; the message is one sentence."""


def main(arguments: Sequence[str], root: Path = ROOT) -> int:
    """Print the selection; 1 if git cannot tell the change."""
    try:
        since = commit(root, arguments[0]) if arguments else start_of_branch(root)
        changed = changed_files(root, since)
        files = {*listed(root, "ls-files", "--cached", "--others", "--exclude-standard"), *changed}
    except GitError as error:
        print(error, file=sys.stderr)
        return 1
    same_code = [path for path in changed if has_same_code(root, since, path)]
    selection = select(Workspace(root, files), changed, same_code)
    print(f"Changed since {since[:8]}: {len(changed)} file(s). {selection.sentence()}", file=sys.stderr)
    print("".join(f"{argument}\n" for argument in selection.arguments), end="")
    return 0


def start_of_branch(root: Path) -> str:
    """Return the commit at which the branch has left main; HEAD where there is no main."""
    for name in MAIN:
        try:
            return git(root, "merge-base", "HEAD", name).strip()
        except GitError:
            continue
    return commit(root, "HEAD")


def commit(root: Path, name: str) -> str:
    """Return the hash of a commit.

    Raises:
        GitError: there is none of this name, or no repository.
    """
    git(root, "rev-parse", "--git-dir")
    try:
        return git(root, "rev-parse", "--verify", "--quiet", f"{name}^{{commit}}").strip()
    except GitError:
        raise GitError(f"Git knows no commit '{name}'; give --changed a branch, a tag or a hash.") from None


def changed_files(root: Path, since: str) -> list[str]:
    """Return what differs from a commit: committed, staged, or not; new and deleted files, too."""
    tracked = listed(root, "diff", "--name-only", "--no-renames", since)
    return sorted({*tracked, *listed(root, "ls-files", "--others", "--exclude-standard")})


def has_same_code(root: Path, since: str, path: str) -> bool:
    """Whether a Python file differs from a commit in comments, docstrings and layout only."""
    if not path.endswith(".py") or not (root / path).is_file():
        return False
    try:
        before, now = (
            code_of(text) for text in (git(root, "show", f"{since}:{path}"), (root / path).read_text())
        )
    except (GitError, SyntaxError):
        return False  # it is new, or no Python
    return now is not None and before == now


def listed(root: Path, *command: str) -> list[str]:
    """Return the paths that a git command prints."""
    return [path for path in git(root, *command, "-z").split("\0") if path]


def git(root: Path, *command: str) -> str:
    """Return what git prints.

    Raises:
        GitError: there is no git, or it fails.
    """
    try:
        done = subprocess.run(("git", *command), cwd=root, capture_output=True, text=True)
    except FileNotFoundError:
        raise GitError("--changed needs git; without it, call ./bringup.sh test.") from None
    if done.returncode != 0:
        said = done.stderr.strip().splitlines()
        reason = said[-1] if said else f"code {done.returncode}"
        raise GitError(f"Git cannot tell what has changed in {root} ({reason}); call ./bringup.sh test.")
    return done.stdout


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
