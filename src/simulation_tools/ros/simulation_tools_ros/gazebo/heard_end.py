"""Lets the node that writes results hear an error that ends the simulator at once."""

from __future__ import annotations

from typing import Callable

import rospy

from simulation_tools.errors import SimulationToolsError
from simulation_tools_ros.gazebo.listeners import wait_for_listener

ShouldStop = Callable[[], bool]


def run_heard(
    run: Callable[[ShouldStop], None], should_stop: ShouldStop, has_begun: Callable[[], bool]
) -> None:
    """Run until told to stop. Before an error that comes at once, wait for ~heard_by; empty: for nobody.

    That is the name of the node that writes down why a run failed. It starts more slowly than the simulator,
    and roslaunch ends it with the simulator.

    run: raises SimulationToolsError. has_begun: whether simulated time has run, so that all nodes are there.
    """
    try:
        run(should_stop)
    except SimulationToolsError:
        listener = str(rospy.get_param("~heard_by", ""))
        if listener and not has_begun():
            wait_for_listener(listener, should_stop)
        raise
