"""The node `exploring`: starts the exploration, swaps the battery, lands, and writes the results."""

from __future__ import annotations

import math
from dataclasses import asdict

import numpy as np
import rospy

from flights.exploring.agreement import home_height_off_m, with_agreement
from flights.exploring.itinerary import Itinerary
from flights.exploring.request import ExploringRequest, read
from flights.exploring.summary import headline
from flights.flight.judging.contacts import UavParts
from flights.flight.monitor import Monitor
from flights.launch_arguments.cepa_parameters import cepa_keeps_m
from flights.results.run_files import FlownRun, complete_run, write_numbers
from flights_ros.drivers.led_flight_node import LedFlightNode
from flights_ros.drivers.parameters import all_parameters
from flights_ros.drivers.progress import ProgressLog
from flights_ros.drivers.run import Run
from flights_ros.drivers.volume_files import save_volume
from flights_ros.exploring.part import COLUMNS, ExplorationPart, ExplorationRecord, figures
from gridslam import SlamError
from gridslam.evaluation.volume.surface import read_surface
from gridslam.volume import VoxelMap, read_octree
from node_tools.ending import Ending
from node_tools.node import RunNode

SCAN_PERIOD_S = 1.0


def make() -> RunNode:
    """Read and check the request. Return the function that flies it and writes the results."""
    asked = rospy.get_param("~", {})
    request = read(asked, cepa_keeps_m(all_parameters().get("cepa", {})))
    lockstep = asked.get("lockstep", False) is True
    return lambda ending: _fly(request, lockstep, ending)


def _fly(request: ExploringRequest, lockstep: bool, ending: Ending) -> int:
    """Return the exit code."""
    run = Run(request.description.experiment, ending)
    monitor = Monitor(request.limits, UavParts.load(request.description.model))
    monitor.log.scan_period_s = SCAN_PERIOD_S
    told_hover_m = request.hover_m if request.sends_hover_height else None
    itinerary, exploration = Itinerary(1, request.swaps), ExplorationPart(monitor, request.time_s)
    run.lead(monitor, lambda: LedFlightNode(monitor, itinerary, (exploration,), lockstep, told_hover_m))
    if not run.interrupted:
        save_volume(run.folder)
    description, wall = run.close(request.description, monitor)
    flown: FlownRun = (run.folder, description, monitor.log, monitor.course.outcome)
    explored = exploration.explored
    numbers = {**write_numbers(*flown, wall), "exploration": figures(explored, itinerary.swapped[0])}
    run.folder.write_result(numbers)
    run.folder.write_csv("exploration.csv", COLUMNS, explored.known)
    return run.finish(
        numbers,
        headline,
        lambda content: _complete(flown, explored, content),
        "clearance or pictures",
    )


def _complete(flown: FlownRun, explored: ExplorationRecord, content: dict) -> dict:
    """Draw the map and the path, and complete the other files."""
    from flights.exploring.pictures import write_explored  # numba and matplotlib take a second

    folder, _, log, _ = flown
    began_s = explored.flights[0].began_s if explored.flights else 0.0
    known = np.array([row[:2] for row in explored.known]).reshape(-1, 2) - (began_s, 0.0)
    try:
        write_explored(folder, folder.path / "map.ot", log.truth.array("x_m", "y_m", "z_m"), known)
    except (SlamError, OSError) as error:
        told = f"There is no explored.png: {error}"
        rospy.logwarn(told)
        folder.lacks(told)
    content = with_judged_map(flown, content)
    folder.write_result(content)
    return complete_run(*flown, content, ProgressLog())


def with_judged_map(flown: FlownRun, content: dict) -> dict:
    """Return the result with what its map is worth: whether it agrees with itself, and how much it knows."""
    from gridslam.evaluation.volume.doubled_surfaces import doubled_share  # numba takes a second

    explored = content["exploration"]
    try:
        voxels = read_octree(flown[0].path / "map.ot")
    except (SlamError, OSError) as error:
        rospy.logwarn(f"What the map is worth is not told: {error}")
        return content
    explored = {**explored, "world": _world_share(flown, voxels)}
    if explored["world"] is None:
        del explored["world"]
    _, _, log, outcome = flown
    off_m = home_height_off_m(log.odometry.array("t_s", "x_m", "y_m", "z_m")) if outcome.landed else math.nan
    judged = with_agreement({**content, "exploration": explored}, doubled_share(voxels), off_m)
    if judged["failure"] != content["failure"]:
        rospy.logwarn(judged["failure"])
    return judged


def _world_share(flown: FlownRun, voxels: VoxelMap) -> dict | None:
    """Return how much of the world's own room is known; None if it has no walls around."""
    from flights.exploring.world_share import known_centres, share_of_world  # numba takes a second

    _, description, log, _ = flown
    path_m = log.truth.array("x_m", "y_m", "z_m")
    try:
        surface = read_surface(description.scenario.world_path)
    except (SlamError, OSError) as error:
        rospy.logwarn(f"How much of the world is known is not told: {error}")
        return None
    if not len(path_m):
        return None
    highest_m, rng = path_m[path_m[:, 2].argmax()], np.random.default_rng(description.seed)
    share = share_of_world(known_centres(voxels), voxels.parameters.resolution_m, surface, highest_m, rng)
    return None if share is None else asdict(share)
