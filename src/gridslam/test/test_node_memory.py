"""What a node of the path takes in memory, and how many maps there are while one is drawn anew."""

import gc
import tracemalloc
import weakref
from functools import partial

import numpy as np
import rooms
from room_paths import path_along

from gridslam.filter.kept.kept_scans import KeptScans
from gridslam.loop_closure.correction import Correction
from gridslam.loop_closure.links.scan_links import SURFACES_MAX as LINKED_MAX
from gridslam.loop_closure.links.scan_links import ScanLinks
from gridslam.loop_closure.local_maps.stretches import SURFACES_MAX, LocalMaps
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.recent import Recent
from gridslam.scan import PlanarScan

ANGLES = np.linspace(-np.pi, np.pi, 180, endpoint=False)
NODES, MORE = max(SURFACES_MAX, LINKED_MAX) + 20, 200
BESIDE_SCAN = 4000
"""Bytes of a node beside its ranges: links with three scans before it, and the arrays' heads."""


def seen_from(x_m: float, stamp_s: float) -> PlanarScan:
    """A scan of a room of 6 x 6 m, x_m from its middle."""
    with np.errstate(divide="ignore"):
        sides = np.where(np.cos(ANGLES) > 0.0, 3.0 - x_m, 3.0 + x_m) / np.abs(np.cos(ANGLES))
        ranges = np.minimum(sides, 3.0 / np.abs(np.sin(ANGLES)))
    return PlanarScan(stamp_s, ANGLES.copy(), ranges, (0.0, 0.0, 0.0), 10.0)


def test_a_node_keeps_little_more_than_its_scan():
    # given a way to and fro through a room, which fills what is kept of the newest nodes
    places_m = np.abs(np.arange(NODES + MORE) % 8 - 4) * 0.5 - 1.0
    path = path_along(np.column_stack([places_m, np.zeros((len(places_m), 2))]))
    kept, maps, links = KeptScans(), LocalMaps(LoopClosureParameters()), ScanLinks(LoopClosureParameters())

    def go_on(first, last):
        for node in range(first, last):
            kept.add(seen_from(float(places_m[node]), float(node)), np.zeros(3))
        maps.extend(kept.scans)
        links.extend(kept.scans, path)

    tracemalloc.start()
    try:
        go_on(0, NODES)
        gc.collect()
        before, _ = tracemalloc.get_traced_memory()
        go_on(NODES, NODES + MORE)
        gc.collect()
        after, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # then the next nodes have their links, and each has taken memory for its ranges and little more
    assert len(links.edges) > 2 * (NODES + MORE)
    assert (after - before) / MORE < ANGLES.nbytes + BESIDE_SCAN


def test_what_is_asked_for_again_is_made_once_and_what_is_not_is_forgotten():
    made = []
    recent = Recent(lambda node: made.append(node) or [node], 2)
    assert [recent.of(node) for node in (3, 4, 3)] == [[3], [4], [3]]
    assert made == [3, 4]
    recent.of(5)  # in the place of 4, which was not asked for so long
    recent.of(3)
    assert (made, len(recent)) == ([3, 4, 5], 2)
    recent.of(4)
    assert made == [3, 4, 5, 4]


def test_a_map_is_drawn_in_the_place_of_the_old_one_and_is_the_same():
    log = rooms.log()
    slams = [rooms.begin(log, keep_scans=True) for _ in range(2)]
    for slam in slams:
        rooms.run(slam, log, 0, 60)
    poses = slams[0].snapshot().poses_in_map + np.array((0.5, -0.3, 0.0))
    old, were_there = weakref.ref(slams[1]._map.tiles), []

    def draw(snapshot):
        were_there.append(old() is not None)
        return snapshot.map_of(poses, 0)

    undrawn = [Correction(poses, draw=partial(draw, slam.snapshot())) for slam in slams]
    beside = undrawn[0].drawn()
    for slam, correction in zip(slams, (beside, undrawn[1])):
        rooms.run(slam, log, 60, 65)
        slam.correct(correction)
        rooms.run(slam, log, 65)
    rooms.assert_same(*slams)
    assert were_there == [True, False]  # first beside the other filter, then in place
