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


def all_of(queue, is_ready=always):
    """What comes out until nothing is left, and what is left out for it."""
    taken = [queue.take(is_ready)]
    while taken[-1].scan is not None:
        taken.append(queue.take(is_ready))
    return [each.scan for each in taken[:-1]], [scan for each in taken for scan in each.too_late]


def gaps(scans):
    """Steps from one number to the next."""
    return [later - earlier for earlier, later in zip(scans, scans[1:])]


@pytest.mark.parametrize("pause", [41, 44, 80, 84, 150, 199])
def test_who_was_busy_gets_scans_at_even_steps_and_the_newest_one(pause):
    # Given scans 0, 1, ... of which 0 was taken before SLAM was busy for so many scans
    queue = filled(0)
    assert queue.take(always).scan == 0
    for scan in range(1, pause + 1):
        assert queue.offer(scan) == []
    # When it has time again
    scans, left_out = all_of(queue)
    # Then it gets as many as may wait, in order, and none of the gaps is twice the mean or more
    assert len(scans) == scan_queue.READY_MAX
    assert sorted(scans + left_out) == list(range(1, pause + 1))
    assert scans[-1] == pause
    assert max(gaps([0, *scans])) <= -(-2 * pause // scan_queue.READY_MAX)


def test_one_pause_after_another_leaves_out_no_bursts():
    # Given SLAM that takes ten scans between two pauses of 55 scans each
    queue, taken, newest = scan_queue.ScanQueue(), [0], 0
    queue.offer(0)
    queue.take(always)
    for _ in range(8):
        for _ in range(55):
            newest += 1
            queue.offer(newest)
        taken += [queue.take(always).scan for _ in range(10)]
    # Then the scans that it gets of the whole time are a few apart
    assert max(gaps(taken)) <= 2 * 55 // 10
    assert queue.offered == newest + 1


def test_scans_that_wait_for_tf_are_not_too_many():
    queue = filled(*range(scan_queue.WAITING_MAX))
    dropped = [scan for late in range(100) for scan in queue.offer(scan_queue.WAITING_MAX + late)]
    assert len(dropped) == 100
    assert len(queue) == scan_queue.WAITING_MAX
    assert queue.ends[1] == scan_queue.WAITING_MAX + 99
    assert max(gaps(queue.clear())) <= 3


def test_late_tf_loses_no_more_than_what_would_come_too_late():
    queue = filled(*range(100))
    scan, too_late, without_tf = queue.take(lambda scan: scan < 90)
    assert scan <= 3
    assert len(too_late) == 90 - scan_queue.READY_MAX
    assert max(too_late) < 89
    assert without_tf == []


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
