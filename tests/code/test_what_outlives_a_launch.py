"""What outlives its launch is known: latched topics and parameters that nodes write have a reason each."""

import re
from pathlib import Path

import pytest
from python_sources import sources

ROOT = Path(__file__).resolve().parents[2]


def those_with(pattern):
    return [path for path in sources() if re.search(pattern, path.read_text(encoding="utf-8"))]


LATCHED = r"latch=True"


def listed(heading):
    """The files in a table of the page."""
    page = (ROOT / "doc/restarts.md").read_text(encoding="utf-8")
    section = page.split(f"## {heading}\n")[1].split("\n## ")[0]
    first = "".join(line.split("|")[1] for line in section.splitlines() if line.startswith("| `"))
    return re.findall(r"`([^`]+)`", first)


@pytest.mark.parametrize(
    ("heading", "pattern"),
    [("Latched topics", LATCHED), ("Parameters that nodes write", r"rospy\.set_param\(")],
)
def test_the_page_lists_each_file_and_no_other(heading, pattern):
    names, found = listed(heading), [path.as_posix() for path in those_with(pattern)]
    missing = [path for path in found if not any(path.endswith(f"/{name}") for name in names)]
    assert not missing, f"doc/restarts.md does not say why what these files keep does no harm: {missing}"
    gone = [name for name in names if not any(path.endswith(f"/{name}") for path in found)]
    assert not gone, f"doc/restarts.md lists too much: {gone}"


def test_a_node_keeps_what_it_needs_after_its_death_for_its_launch_only():
    """Only `KeptParameter` tells a node that died from a node of a later launch."""
    reads = those_with(r"(get_param|has_param)\(\s*\"~(begun|kept|take_off|obeys)\"")
    assert not reads, f"read it with KeptParameter: {reads}"


def test_nobody_latches_where_to_fly():
    """Of several senders that latch, a listener that starts again gets the last message of each."""
    latched = those_with(r'"pos_setpoint"[^)]*latch=True')
    assert not latched, f"send it with SetpointSender: {latched}"
