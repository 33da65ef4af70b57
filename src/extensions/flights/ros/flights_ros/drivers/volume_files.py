"""Keeps the map of voxels that `slam_octomap` has made: map.bt, map.ot and a picture, in the run's folder.

On request also map.state, which has the clouds.
"""

from __future__ import annotations

import numpy as np
import rospy
from octomap_msgs.srv import GetOctomap
from std_srvs.srv import Trigger

from flights.errors import ResultsError
from flights.results.picture_files import pdf, png
from flights.results.run_folder import RunFolder
from gridslam import MapError
from gridslam.volume import VolumeParameters, VoxelMap, map_from, stream_of, write_octree
from gridslam.volume.drawing.picture import volume_figure
from node_tools.services import ServiceCall

SERVICE, NODE = "/octomap_full", "/slam_octomap"
PATIENCE_S, WRITING_S = 20.0, 300.0
"""Wall time to wait for the map's node, and for a large map."""


def has_volume() -> bool:
    """Whether `slam_octomap` maps this flight."""
    return rospy.get_param("~volume", False) is True


def save_volume(folder: RunFolder) -> bool:
    """Ask for the map, if the flight has one, and write its files. Without it the results lack something.

    Returns whether there is one.
    """
    if not has_volume():
        return False
    try:
        octree = ServiceCall(SERVICE, GetOctomap, WRITING_S, wait_s=PATIENCE_S)().map
        data = np.array(octree.data, np.int8).tobytes()
        voxels = map_from(data, octree.binary, VolumeParameters(resolution_m=octree.resolution), octree.id)
        _write(folder, voxels)
    except (rospy.ROSException, rospy.ServiceException) as error:
        told = f"There is no map.bt: slam_octomap gave no map ({error})."
    except (MapError, ResultsError) as error:
        told = f"There is no map.bt: {error}"
    else:
        return True
    rospy.logwarn(told)
    folder.lacks(told)
    return False


def save_clouds(folder: RunFolder) -> None:
    """Let `slam_octomap` write map.state. If it does not, that is told: a plan on the map is coarser then."""
    rospy.set_param(f"{NODE}/state_file", str(folder.path / "map.state"))
    try:
        answer = ServiceCall(f"{NODE}/save_state", Trigger, WRITING_S, wait_s=PATIENCE_S)()
        told = "" if answer.success else answer.message
    except (rospy.ROSException, rospy.ServiceException) as error:
        told = str(error)
    if told:
        rospy.logwarn(f"There is no map.state, so the plan needs more photographs and shows less: {told}")


def _write(folder: RunFolder, voxels: VoxelMap) -> None:
    for name, is_binary in (("map.bt", True), ("map.ot", False)):
        write_octree(folder.path / name, stream_of(voxels, is_binary), voxels.parameters.resolution_m)
    title = f"Occupied voxels of {voxels.parameters.resolution_m:g} m"
    figure = volume_figure(voxels, title)
    folder.write_files({"volume.png": png(figure), "volume.pdf": pdf(figure)})
