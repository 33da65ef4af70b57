"""Models inside models: their links, joints and plugins as the outer model has them, ``inner::name``."""

from __future__ import annotations

from dataclasses import replace

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Joint, Link, Model, Plugin


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


def _held(link: Link, joint: Joint | None) -> Joint:
    """Return the fixed joint that holds a link of a static model in the world; joint: to it, if any."""
    name, pose = (f"{link.name}_static", Pose()) if joint is None else (joint.name, joint.pose)
    return Joint(name, "fixed", parent="world", child=link.name, pose=pose)


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
