"""Given a disk that gets full, files that belong together stay as they were, all of them."""

import errno
import os

import pytest

from inspection.files import whole as whole_files
from inspection.files.whole import write_whole


@pytest.mark.table("number", [1, 2])
def test_a_full_disk_changes_none_of_several_files(tmp_path, monkeypatch, number):
    first, second = tmp_path / "a.npz", tmp_path / "a.json"
    write_whole({first: b"1", second: b"1"})
    settled = []

    def full(descriptor):
        settled.append(descriptor)
        if len(settled) == number:
            os.truncate(descriptor, 0)
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(whole_files, "settle", full)
    with pytest.raises(OSError, match="No space"):
        write_whole({first: b"2", second: b"2"})
    assert [each.read_bytes() for each in (first, second)] == [b"1", b"1"]
    assert sorted(tmp_path.iterdir()) == [second, first]


def test_what_is_written_is_on_the_disk_before_it_gets_its_name(tmp_path, monkeypatch):
    """Else a loss of power leaves the name with nothing in it."""
    order = []
    monkeypatch.setattr(whole_files, "settle", lambda _: order.append("settled"))
    monkeypatch.setattr(whole_files, "settle_folder", lambda _: order.append("folder"))
    replace = os.replace
    monkeypatch.setattr(whole_files.os, "replace", lambda *paths: (order.append("named"), replace(*paths)))
    write_whole({tmp_path / "a": b"1", tmp_path / "b": b"2"})
    assert order == ["settled", "settled", "named", "named", "folder"]
