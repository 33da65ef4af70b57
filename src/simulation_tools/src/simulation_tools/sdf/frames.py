"""The tree of coordinate frames of a model, and how one model is attached to another or lies inside it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, sin
from typing import Sequence

from simulation_tools.geometry import IDENTITY, Pose
from simulation_tools.sdf.document import Node
from simulation_tools.sdf.elements import CameraSensor, Joint, Link, Model, Plugin
from simulation_tools.sdf.safe_xml import SdfError

OPTICAL = Pose(orientation_xyzw=(-0.5, 0.5, -0.5, 0.5))
"""Pose of a camera's optical frame (x right, y down, z ahead) in the camera's (x ahead, y left, z up)."""


@dataclass(frozen=True)
class Frame:
    """An edge of the frame tree. pose: of the child in the parent, a moving joint at its zero position.

    joint: the revolute joint that moves the child, None if the edge is rigid.
    """

    parent: str
    child: str
    pose: Pose
    joint: Joint | None = None

    def at_angle(self, angle_rad: float) -> Pose:
        """Return the pose of the child in the parent with the joint turned by an angle."""
        if self.joint is None:
            return self.pose
        return self.pose @ joint_rotation(self.joint, angle_rad)


def joint_rotation(joint: Joint, angle_rad: float) -> Pose:
    """Return the pose of the turned child link in the child link at angle zero."""
    half = 0.5 * angle_rad
    x, y, z = (component * sin(half) for component in joint.axis)
    return joint.pose @ Pose(orientation_xyzw=(x, y, z, cos(half))) @ joint.pose.inverse()


def model_frames(model: Model) -> list[Frame]:
    """Return every frame of a model as an edge from its parent, parents before children.

    The root is the first link. It is also the parent of every link without a joint. A link has its name in
    the file, a sensor is called ``link/sensor``, and the optical frame of a camera ``link/sensor_optical``.
    A joint has its own name; its frame is a leaf on the child link, at the axis. So each frame has one
    parent, as TF demands.
    """
    links = {link.name: link for link in model.links}
    joint_to = {joint.child: joint for joint in model.joints}
    root = root_link(model)
    edges = {
        name: _link_edge(link, joint_to.get(name), links, root)
        for name, link in links.items()
        if link != root
    }
    frames = _parents_first(edges, root.name)
    for link in model.links:
        for sensor in link.sensors:
            name = f"{link.name}/{sensor.name}"
            frames.append(Frame(link.name, name, sensor.pose))
            if isinstance(sensor, CameraSensor):
                frames.append(Frame(name, optical_frame(name), OPTICAL))
    taken = set(links)
    frames += [
        Frame(joint.child, joint.name, joint.pose) for joint in model.joints if joint.name not in taken
    ]
    return frames


def optical_frame(sensor_frame: str) -> str:
    """Return the name of the optical frame of a camera ``link/sensor``."""
    return f"{sensor_frame}_optical"


def root_link(model: Model) -> Link:
    """Return the link that carries the model: the first one, or where its chain of joints begins."""
    links = {link.name: link for link in model.links}
    parent_of = {joint.child: joint.parent for joint in model.joints}
    name = model.links[0].name
    for _ in links:
        parent = parent_of.get(name)
        if parent is None or parent == "world":
            break
        name = parent
    return links[name]


def attach(model: Model, payload: Model, link: str = "base_link", pose: Pose = IDENTITY) -> Model:
    """Return the model with a payload (e.g. a lidar) fixed to one of its links.

    pose: of the payload's model frame in that link's frame. The payload's links keep their names, its first
    one is joined by a fixed joint ``<link>_joint``. Its mass is added to the model's. Raises SdfError if the
    link does not exist or if a name would occur twice.
    """
    links = {own.name: own for own in model.links}
    if link not in links:
        raise SdfError(f'{model.source}:1: The model "{model.name}" has no link "{link}" to carry a payload.')
    placed = links[link].pose @ pose
    added = tuple(replace(own, pose=placed @ own.pose) for own in payload.links)
    carrier = root_link(payload)
    joint = Joint(f"{carrier.name}_joint", "fixed", parent=link, child=carrier.name)
    joints = (*model.joints, joint, *payload.joints)
    for names in ([own.name for own in (*model.links, *added)], [own.name for own in joints]):
        twice = [name for name in names if names.count(name) > 1]
        if twice:
            raise SdfError(f'{payload.source}:1: "{twice[0]}" exists already in the model "{model.name}".')
    return replace(
        model,
        links=(*model.links, *added),
        joints=joints,
        plugins=(*model.plugins, *payload.plugins),
        warnings=tuple(dict.fromkeys((*model.warnings, *payload.warnings))),
    )


def flattened_links(model: Model) -> list[Link]:
    """Return a nested model's links, their poses in the outer model's frame."""
    return [
        replace(link, name=f"{model.name}::{link.name}", pose=model.pose @ link.pose) for link in model.links
    ]


def flattened_joints(model: Model) -> list[Joint]:
    """Return a nested model's joints under their outer names; a static one's links are fixed to the world."""

    def outer(name: str) -> str:
        return name if name == "world" else f"{model.name}::{name}"

    joints = model.joints
    if model.static:
        carried = {joint.child: joint for joint in model.joints}
        joints = tuple(_held(link, carried.get(link.name)) for link in model.links)
    return [
        replace(joint, name=outer(joint.name), parent=outer(joint.parent), child=outer(joint.child))
        for joint in joints
    ]


def flattened_plugins(model: Model) -> list[Plugin]:
    """Return a nested model's plugins; what they name of its links and joints under the outer names."""
    names = {link.name for link in model.links} | {joint.name for joint in model.joints}

    def outer(key: str, value: str) -> str:
        is_name = value in names and ("link" in key.lower() or "joint" in key.lower())
        return f"{model.name}::{value}" if is_name else value

    return [
        replace(plugin, parameters={key: outer(key, value) for key, value in plugin.parameters.items()})
        for plugin in model.plugins
    ]


def _held(link: Link, joint: Joint | None) -> Joint:
    """Return the fixed joint that holds a link of a static model in the world; joint: to it, if any."""
    name, pose = (f"{link.name}_static", Pose()) if joint is None else (joint.name, joint.pose)
    return Joint(name, "fixed", parent="world", child=link.name, pose=pose)


def _link_edge(link: Link, joint: Joint | None, links: dict[str, Link], root: Link) -> Frame:
    parent = root if joint is None or joint.parent == "world" else links[joint.parent]
    moving = joint if joint is not None and joint.kind == "revolute" else None
    return Frame(parent.name, link.name, parent.pose.inverse() @ link.pose, moving)


def _parents_first(edges: dict[str, Frame], root: str) -> list[Frame]:
    ordered: list[Frame] = []
    reached = {root}
    waiting = list(edges.values())
    while waiting:
        ready = [frame for frame in waiting if frame.parent in reached]
        ordered += ready
        reached.update(frame.child for frame in ready)
        waiting = [frame for frame in waiting if frame.child not in reached]
    return ordered


def frames_in(model: Model) -> dict[str, Pose]:
    """Return the poses of a model's links and joints in its own frame. A link hides a joint of its name."""
    links = {link.name: link.pose for link in model.links}
    return {joint.name: links[joint.child] @ joint.pose for joint in model.joints} | links


class WorldFrames:
    """The named frames of a world: its models, their links and joints, and its ``<frame>``s.

    models: with their elements, before they are placed. frames: the world's ``<frame>`` elements.
    """

    def __init__(self, models: Sequence[tuple[Node, Model]], frames: Sequence[Node]) -> None:
        self._raw: dict[str, tuple[Pose, str]] = {}
        for frame in frames:
            pose, relative_to = frame.pose()
            usual = frame.attribute("attached_to", "")
            self._raw[frame.attribute("name")] = pose, relative_to or usual
        for _, model in models:
            self._raw.setdefault(model.name, (model.pose, model.relative_to))
            for name, pose in frames_in(model).items():
                self._raw.setdefault(f"{model.name}::{name}", (pose, model.name))

    def placed(self, model: Model, node: Node) -> Model:
        """Return a model with its pose in the world; raises SdfError if its frame leads nowhere."""
        pose = self._in_world(model.relative_to, node, ()) @ model.pose
        return replace(model, pose=pose, relative_to="")

    def _in_world(self, name: str, asker: Node, trail: tuple[str, ...]) -> Pose:
        if name in ("", "world"):
            return IDENTITY
        if name in trail:
            raise asker.error(f'The frame "{name}" is defined through itself')
        if name not in self._raw:
            raise asker.error(f'There is no frame "{name}" in this world')
        pose, relative_to = self._raw[name]
        return self._in_world(relative_to, asker, (*trail, name)) @ pose
