"""Reader of ``<actor>``: a model that a script moves along trajectories of waypoints.

Its own links give it its shape, as in Gazebo's world ``animated_box``. An actor with a skin and without links
is a person: Gazebo draws it from its skeleton, and here an upright cylinder stands for it.
"""

from __future__ import annotations

from dataclasses import replace

from simulation_tools.geometry import Pose
from simulation_tools.sdf.checks import NOT_NEGATIVE, Check, whole_number
from simulation_tools.sdf.document import Node
from simulation_tools.sdf.elements import (
    DEFAULT_INERTIAL,
    Collision,
    Cylinder,
    Link,
    Model,
    Script,
    Trajectory,
    Visual,
    Waypoint,
)
from simulation_tools.sdf.models import checked_name, read_model
from simulation_tools.sdf.reading import Reading

_BODY = Cylinder(radius_m=0.3, length_m=1.8)
PERSON = Link(
    "person",
    Pose(),
    DEFAULT_INERTIAL,
    (Collision("body", Pose(), _BODY),),
    (Visual("body", Pose(), _BODY, (0.2, 0.4, 0.7, 1.0)),),
)
"""Stands for a skin. The frame of Gazebo's person is at its hip, a metre above the ground."""

TRAJECTORY_ID = whole_number(0, 1_000_000)
TENSION = Check("from 0 to 1", lambda value: 0.0 <= value <= 1.0)


def read_actor(node: Node, reading: Reading) -> Model:
    """Read an actor as a static model with a script. Raises SdfError."""
    node.accept("skin", "animation", "static")
    script = _read_script(node.required("script"))
    if node.children_unmarked("link"):
        model = read_model(node, reading, static=True)
    else:
        pose, _ = node.pose()
        model = Model(checked_name(node), pose, True, (PERSON,), source=node.document.name)
    return replace(model, static=True, script=script)


def _read_script(node: Node) -> Script | None:
    """Read a script; None when it has no trajectory, so that the actor stands where it is."""
    trajectories = sorted(
        ((child.number_attribute("id", 0.0, TRAJECTORY_ID), child) for child in node.children("trajectory")),
        key=lambda numbered: numbered[0],
    )
    for (number, _), (other, child) in zip(trajectories, trajectories[1:]):
        if number == other:
            raise child.error(f"A second <trajectory> has the id {number:g}")
    loop = node.flag("loop", True)
    delay_s, starts = node.value("delay_start", 0.0, NOT_NEGATIVE), node.flag("auto_start", True)
    if not trajectories:
        return None
    return Script(
        tuple(_read_trajectory(child) for _, child in trajectories),
        loop=loop,
        delay_s=delay_s,
        starts=starts,
    )


def _read_trajectory(node: Node) -> Trajectory:
    waypoints: list[Waypoint] = []
    for child in node.children("waypoint"):
        time_s = child.required_value("time", NOT_NEGATIVE)
        if waypoints and time_s <= waypoints[-1].time_s:
            raise child.error(
                f"The times of the waypoints must increase, but {time_s:g} s follows "
                f"{waypoints[-1].time_s:g} s"
            )
        child.required("pose")
        pose, frame = child.pose()
        if frame not in ("", "world"):
            raise child.error(f'A waypoint is in the world frame, not in "{frame}"')
        waypoints.append(Waypoint(time_s, pose))
    if not waypoints or waypoints[-1].time_s == 0.0:
        raise node.error("<trajectory> needs a <waypoint> at a time above 0 s")
    return Trajectory(tuple(waypoints), node.number_attribute("tension", 0.0, TENSION))
