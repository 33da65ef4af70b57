"""Layers of the volume: what changed is told once, whoever looked at the map meanwhile."""

import numpy as np
from gridslam_ros.volume.layers import Layers
from gridslam_ros.volume.parameters import OctomapParameters

from gridslam.volume import OCCUPIED, CorrectedMap, Pose, ShownMap


def test_a_service_between_two_publications_takes_no_change_away():
    parameters = OctomapParameters()
    layers, corrected = Layers(parameters), CorrectedMap(parameters.volume)
    assert layers.distances is not None  # they are kept from now on
    corrected.add(0.0, np.array([(1.0, 0.5, 0.2)], np.float32), Pose.identity(), Pose.identity())
    layers.refresh(corrected)  # a service
    layers.refresh(corrected)  # the publisher
    changed, renewed = layers.take_changes()
    assert len(changed) > 0
    assert len(renewed) > 0
    layers.refresh(corrected)
    assert [len(tiles) for tiles in layers.take_changes()] == [0, 0]


def test_a_map_without_voxels_asks_rviz_for_no_empty_list():
    from gridslam_ros.volume.messages import markers_of
    from std_msgs.msg import Header
    from visualization_msgs.msg import Marker

    (cubes,) = markers_of(ShownMap(0.2), OCCUPIED, Header(), (-1.0, 1.0)).markers
    assert cubes.action == Marker.DELETE  # RViz calls an empty list an error
