"""The snippets of the pages: found, run by bash, and what they call is looked at.

Bash runs every block as it is pasted, in a copy of the workspace made of links, with a home of its own. What
is dear or needs more than a test has (`Call` below) is a function there that writes down its words; all else
(cd, mkdir, export, ls, chmod, source, ...) runs.
"""

from __future__ import annotations

import os
import re
import subprocess
import textwrap
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CALLED = (
    "./bringup.sh",
    ".venv/bin/python",
    "roslaunch",
    "rosrun",
    "rostopic",
    "rosbag",
    "rosparam",
    "rosservice",
    "rosnode",
    "rqt",
    "rviz",
    "ign",
)
"""What bash does not run, but writes down."""
ELSEWHERE = re.compile(
    r"(?m)(?:^|&& |; |\| )"
    r"(?:sudo|apt-get|git|wget|curl|wstool|vcs|rosdep|catkin\w*|c?make|pip|build/px4\S*) "
)
"""A command that needs root, the network or foreign sources."""
COMMANDS = re.compile(r"^(roslaunch|rosrun|rostopic|rosbag|rosparam|\./bringup\.sh|\.venv/bin/python) ")
SHELL = ("sh", "bash", "shell", "console")


@dataclass(frozen=True)
class Snippet:
    """A block of commands on a page. What stands in [brackets] is optional."""

    page: str
    number: int
    text: str

    @property
    def runnable(self) -> list[str]:
        """What bash is to run: the block without optional words; of one for elsewhere, its lines for here."""
        text = re.sub(r" \[[^\]]*\]", "", self.text)
        if not ELSEWHERE.search(text):
            return [text]
        parsed = subprocess.run(["bash", "-n"], input=text, capture_output=True, text=True)
        assert parsed.returncode == 0, parsed.stderr
        return [line for line in text.splitlines() if COMMANDS.match(line)]


@dataclass(frozen=True)
class Call:
    """A command as bash called it: its words, after all that bash makes of them, and the folder."""

    folder: str
    words: tuple[str, ...]


@cache
def pages() -> list[str]:
    """Return the pages that users read."""
    found = [ROOT / "README.md", *ROOT.glob("benchmarks/*.md"), *ROOT.glob("doc/*.md")]
    found += [
        path
        for path in ROOT.glob("src/**/*.md")
        if path.name == "README.md" or path.parent.name in ("doc", "models")
    ]
    return sorted(str(path.relative_to(ROOT)) for path in found)


def fenced(page: str, *languages: str) -> list[str]:
    """Return the fenced blocks of a page that are marked as one of these languages."""
    text = (ROOT / page).read_text(encoding="utf-8")
    found = re.findall(r"^( *)```(\w*)\n(.*?)^ *```$", text, re.S | re.M)
    return [textwrap.dedent(block) for _, language, block in found if language in languages]


def shell_snippets(page: str) -> list[Snippet]:
    """Return a page's commands: blocks marked as shell's, and indented ones that begin with one of ours."""
    text = re.sub(r"^( *)```.*?^ *```$", "", (ROOT / page).read_text(encoding="utf-8"), flags=re.S | re.M)
    indented = [textwrap.dedent(block) for block in re.findall(r"(?:^    .*\n)+", text, re.M)]
    blocks = fenced(page, *SHELL) + [block for block in indented if COMMANDS.match(block)]
    return [Snippet(page, number, block) for number, block in enumerate(blocks)]


def workspace(folder: Path) -> Path:
    """Make a copy of the workspace out of links, in which snippets may make files; return its folder."""
    made = folder / "workspace"
    (made / "src").mkdir(parents=True)
    left_out = {"src", "results", "logs", ".git"}
    for path in [path for path in ROOT.iterdir() if path.name not in left_out] + list(ROOT.glob("src/*")):
        (made / path.relative_to(ROOT)).symlink_to(path)
    return made


def run(text: str, place: Path, home: Path, timeout_s: float = 60.0) -> list[Call]:
    """Let bash run a snippet in a folder; return what it called.

    Raises:
        AssertionError: a command of it failed.
    """
    log = home / "calls"
    log.unlink(missing_ok=True)
    stubs = "".join(f'function {name} {{ called {name} "$@"; }}\n' for name in CALLED)
    script = (
        f'called() {{ {{ printf \'%s\\0\' "$PWD" "$#" "$@"; }} >> \'{log}\'; }}\n'
        f"{stubs}set -e\ncd '{place}'\n{text}\nwait\n"
    )
    done = subprocess.run(
        ["bash", "-c", script],
        env={**os.environ, "HOME": str(home)},
        capture_output=True,
        text=True,
        timeout=timeout_s,
    )
    assert done.returncode == 0, f"{text}\n{done.stderr}"
    return _calls(log)


def _calls(log: Path) -> list[Call]:
    fields = log.read_text(encoding="utf-8").split("\0")[:-1] if log.exists() else []
    calls = []
    while fields:
        folder, count, fields = fields[0], int(fields[1]), fields[2:]
        calls.append(Call(folder, tuple(fields[:count])))
        fields = fields[count:]
    return calls
