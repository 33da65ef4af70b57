"""Which frames a UAV carries, in trees of TF as drivers and SLAMs make them."""

import pytest

from input_checks.carried_frames import CarriedFrames

USUAL = [("map", "odom", False), ("odom", "base", False), ("base", "lidar", True)]
NODS = [("map", "odom", False), ("odom", "base", False), ("base", "arm", True), ("arm", "lidar", False)]
LIDAR_ABOVE = [("camera_init", "body", False), ("body", "base", True)]
ON_THE_GROUND = [*USUAL, ("map", "tripod", True)]
AT_REST = [("base", "lidar", True)]


@pytest.mark.table(
    ("edges", "frame", "is_carried"),
    [
        (USUAL, "lidar", True),
        (USUAL, "base", True),
        (USUAL, "odom", False),
        (USUAL, "map", False),
        (USUAL, "elsewhere", True),  # TF does not tell
        (NODS, "lidar", True),
        (LIDAR_ABOVE, "body", True),
        (LIDAR_ABOVE, "camera_init", False),
        (ON_THE_GROUND, "tripod", False),
        (AT_REST, "lidar", True),
    ],
)
def test_a_frame_is_carried_if_it_hangs_on_what_moves_with_the_base(edges, frame, is_carried):
    frames = CarriedFrames()
    for edge in edges:
        frames.add(*edge)
    assert (frames.lacks("base", frame) == "") == is_carried


def test_a_world_is_carried_by_nobody_whatever_tf_tells():
    frames = CarriedFrames()
    assert '"map"' in frames.lacks("base", "map", ("odom", "map"))


def test_edges_in_a_circle_end():
    frames = CarriedFrames()
    for edge in (("a", "base", True), ("base", "a", True)):
        frames.add(*edge)
    assert frames.lacks("base", "b") == ""
