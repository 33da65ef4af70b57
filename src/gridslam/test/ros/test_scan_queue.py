"""The queue of scans: in order, bounded, and never stuck behind a scan whose transforms do not come."""

import pytest

scan_queue = pytest.importorskip(
    "gridslam_ros.scan_queue", reason="the workspace is not built, or not sourced"
)


def filled(*scans):
    queue = scan_queue.ScanQueue()
    for scan in scans:
        assert queue.offer(scan) == []
    return queue


def always(_):
    return True


def never(_):
    return False


def test_scans_come_out_in_order():
    queue = filled(1, 2, 3)
    assert [queue.take(always).scan for _ in range(4)] == [1, 2, 3, None]


def test_a_scan_waits_for_its_transforms():
    queue = filled(1, 2)
    assert queue.take(never) == (None, [], [])
    assert queue.take(lambda scan: scan <= 1) == (1, [], [])
    assert queue.take(lambda scan: scan <= 1) == (None, [], [])
    assert queue.take(lambda scan: scan <= 2) == (2, [], [])


def test_who_is_too_busy_leaves_the_oldest_out():
    queue = filled(*range(10 + scan_queue.READY_MAX))
    assert queue.take(always) == (10, list(range(10)), [])
    assert queue.take(always) == (11, [], [])


def test_scans_that_wait_for_tf_are_not_too_many():
    queue = filled(*range(scan_queue.WAITING_MAX))
    assert queue.offer("new") == [0]
    assert len(queue) == scan_queue.WAITING_MAX
    assert queue.ends == (1, "new")


def test_late_tf_loses_no_more_than_what_would_come_too_late():
    queue = filled(*range(100))
    left_out = 90 - scan_queue.READY_MAX
    assert queue.take(lambda scan: scan < 90) == (left_out, list(range(left_out)), [])


def test_a_scan_without_transforms_does_not_hold_up_the_others():
    queue = filled("lost", 1, 2)
    assert queue.take(lambda scan: scan != "lost") == (1, [], ["lost"])


def test_where_nothing_waits_for_real_there_is_room_for_all():
    queue = scan_queue.ScanQueue(waiting_max=None, ready_max=None)
    assert [queue.offer(scan) for scan in range(1000)] == [[]] * 1000
    assert queue.take(always) == (0, [], [])


def test_cleared_it_is_empty():
    queue = filled(1, 2)
    assert queue.clear() == [1, 2]
    assert len(queue) == 0
