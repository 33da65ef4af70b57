"""Threads: every particle once, as many threads as cores are free, and always the same result."""

import dataclasses
import io
import threading

import numpy as np
import planar_world
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gridslam import SlamParameters
from gridslam.filter import workers
from gridslam.filter.grid_slam import GridSlam
from gridslam.filter.workers import FreeCores, Usage, Workers, cores, usage


@given(st.integers(1, 40), st.integers(1, 6))
def test_every_particle_is_computed_once(particles, threads):
    times = np.zeros(particles, int)

    def kernel(first, last, amount):
        times[first:last] += amount

    Workers(threads).share(particles, kernel, 3)
    assert (times == 3).all()


def test_two_threads_work_at_once():
    meeting = threading.Barrier(2, timeout=30.0)  # one thread alone would wait in vain
    Workers(2).share(2, lambda first, last: meeting.wait())


@pytest.mark.table(
    ("idle_cores", "own_cores", "free"),
    [(2.0, 0.0, 2), (0.1, 1.8, 2), (0.5, 0.3, 1), (0.0, 0.0, 1), (3.0, 0.9, 4), (1.4, 0.3, 2)],
)
def test_free_are_cores_that_idle_and_those_already_ours(idle_cores, own_cores, free):
    readings = iter(
        Usage(100.0 + s, 5000.0 + idle_cores * s, 7.0 + own_cores * s) for s in (0.0, 0.1, 1.0, 1.1)
    )
    looked = FreeCores(lambda: next(readings))
    assert [looked.count() for _ in range(3)] == [1, free, free]


def test_the_machine_tells_how_busy_it_is():
    before, after = usage(), usage()
    if before is None:
        pytest.skip("this system has no /proc/stat")
    assert before.wall_s <= after.wall_s
    assert before.own_s <= after.own_s
    assert min(before.idle_s, after.idle_s) >= 0.0  # Linux does not promise that it rises
    assert FreeCores().count() >= 1
    assert cores() >= 1


@pytest.mark.table("words", ["", "cpu", "cpu 1 2 3\n", "cpu a b c d e f\n", None])
def test_a_machine_that_does_not_tell_has_one_free_core(words, monkeypatch):
    def answer(path):
        assert path == "/proc/stat"
        if words is None:
            raise FileNotFoundError(path)
        return io.StringIO(words)

    monkeypatch.setattr(workers, "open", answer, raising=False)
    assert usage() is None
    assert FreeCores().count() == 1


def test_the_result_does_not_depend_on_how_many_cores_are_free():
    lidar = planar_world.Lidar(6.2, 90, 20.0, 0.01, 10.0)
    route = planar_world.along(np.array([(-8.0, -5.0), (-3.0, -5.0)]), 0.25)
    log = planar_world.drive(planar_world.hold(), route, lidar, seed=4)
    alone = SlamParameters(particles=7, linearUpdate=0.4, delta=0.1, threads=1)
    slams = [
        GridSlam(dataclasses.replace(alone, threads=threads), None, log.odometry[0]) for threads in (1, 0)
    ]
    numbers = np.random.default_rng(1).integers(1, 5, 100).tolist()
    slams[1]._workers = Workers(0, free_cores=iter(numbers).__next__)  # cores become free, and busy
    for scan, odometry in zip(log.scans, log.odometry):
        for slam in slams:
            slam.process(scan, odometry)
    for ask in ("particle_poses", "particle_weights"):
        np.testing.assert_array_equal(getattr(slams[0], ask), getattr(slams[1], ask))
    np.testing.assert_array_equal(slams[0].grid().cells, slams[1].grid().cells)
