"""Bags of before are read: `rosbag fix` gives messages that were inspection_tools' their new package."""

from __future__ import annotations

import os
import sys
from importlib import import_module
from pathlib import Path

import pytest

rosbag = pytest.importorskip("rosbag", reason="needs ROS")
import genpy  # noqa: E402
from launch_files import run  # noqa: E402

pytestmark = [
    pytest.mark.ros,
    pytest.mark.skipif(
        sys.version_info >= (3, 13),
        reason="Debian 13's rosbag fix applies no rule at all (KeyError, Python 3.13)",
    ),
]
ROOT = Path(__file__).resolve().parents[2]
PARTS = ("ActionGoal", "ActionResult", "ActionFeedback")
MOVED = [("exploration", f"Explore{part}") for part in PARTS] + [
    ("inspection", f"Survey{part}") for part in PARTS
]
MOVED += [("inspection", name) for name in ("Candidates", "Photograph")]
RULES = "migration/from_inspection_tools.bmr"
STAMP = genpy.Time(7, 5)


def of_before(package: str, name: str):
    """The class of a message as it was when it was inspection_tools'."""
    text = getattr(import_module(f"{package}.msg"), name)._full_text
    text = text.replace(f"MSG: {package}/", "MSG: inspection_tools/")
    return genpy.dynamic.generate_dynamic(f"inspection_tools/{name}", text)[f"inspection_tools/{name}"]


def filled(message, depth: int = 0):
    """A message with a value in each field of text, and one message in each list."""
    for field, kind in zip(message.__slots__, message._slot_types):
        value = getattr(message, field)
        if kind == "string":
            setattr(message, field, f"{field} {depth}")
        elif kind in ("float32", "float64"):
            setattr(message, field, 0.5)
        elif hasattr(value, "_slot_types"):
            filled(value, depth + 1)
    return message


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    """A bag of before with one message of each kind, and the bag that `rosbag fix` makes of it."""
    folder = tmp_path_factory.mktemp("bags")
    old, new = folder / "old.bag", folder / "new.bag"
    with rosbag.Bag(str(old), "w") as bag:
        for package, name in MOVED:
            bag.write(f"/{package}/{name}", filled(of_before(package, name)()), STAMP)
    rules = [str(ROOT / "src/extensions" / package / RULES) for package in ("exploration", "inspection")]
    done = run("rosbag", "fix", str(old), str(new), *rules)
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stdout + done.stderr
    return old, new


def test_a_bag_of_before_holds_messages_of_the_new_package(bags):
    old, new = bags
    with rosbag.Bag(str(old)) as before, rosbag.Bag(str(new)) as after:
        messages = {topic: (message, stamp) for topic, message, stamp in after.read_messages()}
        assert sorted(messages) == sorted(f"/{package}/{name}" for package, name in MOVED)
        for topic, message, stamp in before.read_messages():
            found, at = messages[topic]
            assert found._type == topic[1:]
            assert (str(found), at) == (str(message), stamp)


def test_the_new_bag_is_read_by_the_classes_of_today(bags):
    with rosbag.Bag(str(bags[1])) as bag:
        for connection in bag._get_connections():
            package, name = connection.datatype.split("/")
            assert getattr(import_module(f"{package}.msg"), name)._md5sum == connection.md5sum
    assert os.path.getsize(bags[1]) > 0
