"""Checks the TF tree: one parent for each frame, one piece, no gaps in time (REP-105)."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import Iterator, Sequence

from doctor import clock
from doctor.diagnosis import ERROR, NOTE, WARNING, Diagnosis
from doctor.snapshot import Recording, Transform

GAP_S = 0.5
"""In a gap longer than its time-out, here 0.5 s, a look-up at a scan's stamp fails."""
OLD_S, FUTURE_S = 1.0, 0.2


def structure(recording: Recording) -> list[Diagnosis]:
    """Return all diagnoses about the tree itself."""
    edges = recording.transforms
    return [*parents(edges), *publishers(edges), *pieces(recording), *values(edges)]


def times(recording: Recording) -> Iterator[Diagnosis]:
    """Check the stamps of all edges that are not static."""
    for edge in recording.transforms:
        if not edge.static:
            yield from edge_times(edge, recording)


def parents(edges: Sequence[Transform]) -> Iterator[Diagnosis]:
    """Check whether a frame has several parents. tf2 would use the last one."""
    by_child: dict[str, dict[str, str]] = defaultdict(dict)
    for edge in edges:
        by_child[edge.child].setdefault(edge.parent, edge.publisher)
    for child, found in sorted(by_child.items()):
        if len(found) > 1:
            told = " and ".join(f"{parent} (from {publisher})" for parent, publisher in sorted(found.items()))
            remedy = "Stop one; publish a second relation the other way round, as base_frame -> world here"
            yield Diagnosis(ERROR, f"frame {child}", f"has {len(found)} parents: {told}", remedy)


def publishers(edges: Sequence[Transform]) -> Iterator[Diagnosis]:
    """Check whether two nodes publish the same edge at the same time; one that takes over is no rival."""
    by_edge = defaultdict(list)
    for edge in edges:
        by_edge[edge.parent, edge.child].append(edge)
    for (parent, child), found in sorted(by_edge.items()):
        rivals = {one.publisher for one in found for other in found if one is not other and _meet(one, other)}
        if len(rivals) > 1:
            what = f"{' and '.join(sorted(rivals))} both publish it"
            yield Diagnosis(
                ERROR, f"tf {parent} -> {child}", what, "Stop one of them: the frame jumps between both"
            )


def _meet(one: Transform, other: Transform) -> bool:
    """Return whether two publishers of an edge publish in the same time."""
    if not (one.received_s and other.received_s):
        return True
    return one.received_s[0] < other.received_s[-1] and other.received_s[0] < one.received_s[-1]


def pieces(recording: Recording) -> Iterator[Diagnosis]:
    """Check whether all frames are connected, and whether the scans' frames are among them."""
    parent_of = {edge.child: edge.parent for edge in recording.transforms}
    roots = defaultdict(set)
    for frame in {frame for edge in recording.transforms for frame in (edge.parent, edge.child)}:
        root = _root(frame, parent_of)
        if root is None:
            yield Diagnosis(
                ERROR, f"frame {frame}", "is its own ancestor", "Turn one of the edges of the loop round"
            )
            return
        roots[root].add(frame)
    if len(roots) > 1:
        told = " | ".join(" ".join(sorted(found)) for _, found in sorted(roots.items()))
        remedy = (
            "Start who publishes the missing edge (tf_publisher, gridslam), or a static_transform_publisher"
        )
        yield Diagnosis(ERROR, "tf", f"is in {len(roots)} pieces: {told}", remedy)
    known = {frame for found in roots.values() for frame in found}
    for topic, frame in sorted({(scan.topic, scan.frame) for scan in recording.scans}):
        if frame.lstrip("/") not in known:
            remedy = (
                "Correct the lidar's frame_id, or publish where the lidar sits: static_transform_publisher"
            )
            yield Diagnosis(ERROR, topic, f'its frame "{frame}" is not in TF', remedy)


def _root(frame: str, parent_of: dict[str, str]) -> str | None:
    """Return a frame's root; None in a loop."""
    seen = set()
    while frame in parent_of:
        if frame in seen:
            return None
        seen.add(frame)
        frame = parent_of[frame]
    return frame


def values(edges: Sequence[Transform]) -> Iterator[Diagnosis]:
    """Check the numbers."""
    for edge in edges:
        if edge.broken:
            what = f"{edge.publisher} sends no numbers, or a rotation that is not of unit length"
            yield Diagnosis(
                ERROR, f"tf {edge.parent} -> {edge.child}", what, "tf2 refuses them: look at its source"
            )


def edge_times(edge: Transform, recording: Recording) -> Iterator[Diagnosis]:
    """Check an edge's stamps: no gaps, neither old nor in the future, never going back."""
    where = f"tf {edge.parent} -> {edge.child}"
    if not edge.stamps_s:
        return
    steps_s = [later - earlier for earlier, later in zip(edge.stamps_s, edge.stamps_s[1:])]
    longest_s, backwards = max(steps_s, default=0.0), sum(step < 0.0 for step in steps_s)
    if backwards:
        remedy = "tf2 drops those: a reset of the clock, or two sources"
        yield Diagnosis(WARNING, where, f"its stamps go back {backwards} times ({edge.publisher})", remedy)
    if longest_s > GAP_S and len(steps_s) > 1:
        remedy = f"Look at the load of {edge.publisher} and at what it waits for"
        yield Diagnosis(WARNING, where, f"has a hole of {longest_s:.2f} s", remedy)
    times_s = [
        times
        for times in zip(edge.received_s, edge.latest_s or edge.received_s, edge.stamps_s)
        if not math.isnan(times[0])
    ]
    if not times_s:
        return
    age_s = clock.median(received_s - stamp_s for received_s, _, stamp_s in times_s)
    early_s = clock.median(stamp_s - latest_s for _, latest_s, stamp_s in times_s)
    end_s = recording.end_s
    if early_s > FUTURE_S and clock.is_right(edge.publisher, recording):
        what = f"{edge.publisher} dates it {early_s:.2f} s ahead on purpose: its other stamps are right"
        yield Diagnosis(NOTE, where, what, "AMCL does so by its parameter transform_tolerance")
    elif early_s > FUTURE_S:
        what = f"{edge.publisher} stamps it {early_s:.2f} s into the future"
        yield Diagnosis(ERROR, where, what, clock.ahead(recording.is_simulated))
    elif age_s > OLD_S:
        yield Diagnosis(
            ERROR,
            where,
            f"{edge.publisher} stamps it {age_s:.1f} s late",
            "Look at its load, and at its clock",
        )
    elif end_s - edge.received_s[-1] > max(OLD_S, 3.0 * longest_s):
        what = f"has not come for {end_s - edge.received_s[-1]:.1f} s"
        yield Diagnosis(ERROR, where, what, f"Is {edge.publisher} still alive? Start it again")
    if len(edge.stamps_s) > 50 and len(set(edge.stamps_s)) * 2 < len(edge.stamps_s):
        yield Diagnosis(
            NOTE, where, "is sent again and again with the same stamp", "tf2 warns of each (TF_REPEATED_DATA)"
        )
