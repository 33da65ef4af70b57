"""Reader of ``<model>``: links, joints, nested models, and the frames that their poses are given in."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Callable, Sequence

from simulation_tools.geometry import Pose, Vector3, rotate, rotate_inverse
from simulation_tools.sdf.checks import NOT_NEGATIVE
from simulation_tools.sdf.document import Node, unique
from simulation_tools.sdf.elements import Collision, Geometry, Joint, Link, Model, Visual
from simulation_tools.sdf.plugins import read_plugins
from simulation_tools.sdf.sensors import is_supported, read_sensor
from simulation_tools.sdf.shapes import read_geometry, read_inertial, read_material, read_surface, unit_vector

Include = Callable[[Node], Model | None]
NAME = re.compile(r"[^\s\x00-\x1f]+( [^\s\x00-\x1f]+)*")
MODEL_FRAMES = ("", "__model__")
NO = ("false", "0")
ZERO = ("0", "0.0", "-0.0", "")


def read_model(node: Node, model_path: Sequence[Path], include: Include) -> Model:
    """Read a model whole; include: follows a nested ``<include>``. Raises SdfError."""
    name = checked_name(node)
    node.accept("allow_auto_disable", "enable_wind")
    pose, frame = node.pose()
    if frame not in ("", "world"):
        raise node.error(f'A model cannot be placed in the frame "{frame}"')
    nested = [read_model(child, model_path, include) for child in node.children("model")]
    nested += [_nested_include(child, include) for child in node.children("include")]
    frames = _Frames(node, nested)
    links = [_read_link(child, frames, model_path) for child in frames.link_nodes.values()]
    links += [link for model in nested for link in _flattened_links(model)]
    if not links:
        raise node.error(f'The model "{name}" has no <link>')
    joints = _read_joints(node, frames, {link.name: link for link in links}, nested)
    return Model(
        name=name,
        pose=pose,
        static=node.flag("static", False),
        links=tuple(links),
        joints=joints,
        plugins=(*read_plugins(node), *(plugin for model in nested for plugin in model.plugins)),
        source=node.document.name,
        warnings=tuple(warning for model in nested for warning in model.warnings),
    )


def _nested_include(node: Node, include: Include) -> Model:
    model = include(node)
    if model is None:
        raise node.error("A model can include models only")
    return model


class _Frames:
    """The named frames of a model: links, ``<frame>``s, joints and nested models, resolved on demand.

    If a link and a joint have the same name, the name means the link.
    """

    def __init__(self, model: Node, nested: Sequence[Model]) -> None:
        self.link_nodes = unique(model.children("link"))
        self._raw: dict[str, tuple[Node, Pose, str]] = {}
        self._known: dict[str, Pose] = {}
        joints, frames = unique(model.children("joint")), unique(model.children("frame"))
        for name, node in {**joints, **frames, **self.link_nodes}.items():
            pose, frame = node.pose()
            self._raw[name] = (node, pose, frame or _usual_frame(node))
        for inner in nested:
            self._known[inner.name] = inner.pose
            links = {link.name: inner.pose @ link.pose for link in inner.links}
            joints_of = {joint.name: links[joint.child] @ joint.pose for joint in inner.joints}
            for name, pose in {**joints_of, **links}.items():
                self._known[f"{inner.name}::{name}"] = pose

    def in_model(self, name: str, asker: Node, trail: tuple[str, ...] = ()) -> Pose:
        """Return the pose of a named frame in the model frame."""
        if name in MODEL_FRAMES:
            return Pose()
        if name in trail:
            raise asker.error(f'The frame "{name}" is defined through itself')
        if name not in self._known:
            if name not in self._raw:
                raise asker.error(f'There is no frame "{name}" in this model')
            node, pose, frame = self._raw[name]
            self._known[name] = self.in_model(frame, node, (*trail, name)) @ pose
        return self._known[name]

    def in_link(self, node: Node, link: Pose) -> Pose:
        """Return the pose of an element in its link's frame (link: the link's pose in the model)."""
        pose, frame = node.pose()
        return pose if not frame else link.inverse() @ self.in_model(frame, node) @ pose


def _usual_frame(node: Node) -> str:
    """Return the frame of a link, ``<frame>`` or joint that does not name one itself."""
    if node.tag == "joint":
        return node.required("child").text
    return node.attribute("attached_to", "") if node.tag == "frame" else ""


def checked_name(node: Node) -> str:
    """Return an element's name; SdfError when it cannot be one."""
    name = node.attribute("name")
    if not NAME.fullmatch(name) or name == "world":
        raise node.error(f'"{name}" cannot be the name of a <{node.tag}>')
    return name


def _read_link(node: Node, frames: _Frames, model_path: Sequence[Path]) -> Link:
    node.accept("enable_wind", "must_be_base_link")
    node.accept_value("self_collide", *NO)
    node.accept_value("kinematic", *NO)
    node.accept_empty("velocity_decay")
    name = checked_name(node)
    pose = frames.in_model(name, node)
    return Link(
        name=name,
        pose=pose,
        inertial=read_inertial(node.child("inertial")),
        collisions=_shapes(node, "collision", _read_collision, frames, pose, model_path),
        visuals=_shapes(node, "visual", _read_visual, frames, pose, model_path),
        gravity=node.flag("gravity", True),
        sensors=tuple(
            read_sensor(child.understood(), frames.in_link(child, pose))
            for child in unique(node.children_unmarked("sensor")).values()
            if is_supported(child)
        ),
    )


def _shapes(
    node: Node, tag: str, read: Callable, frames: _Frames, link: Pose, model_path: Sequence[Path]
) -> tuple:
    """Read the collisions or visuals of a link; skip unsupported kinds of geometry."""
    found = []
    for child in unique(node.children(tag)).values():
        geometry = read_geometry(child.required("geometry"), model_path)
        shape = read(child, frames.in_link(child, link), geometry)
        if geometry is not None:
            found.append(shape)
    return tuple(found)


def _read_collision(node: Node, pose: Pose, geometry: Geometry) -> Collision:
    node.accept("max_contacts", "laser_retro")
    return Collision(checked_name(node), pose, geometry, read_surface(node.child("surface")))


def _read_visual(node: Node, pose: Pose, geometry: Geometry) -> Visual:
    node.accept("cast_shadows", "laser_retro", "meta")
    red, green, blue, alpha = read_material(node.child("material"))
    alpha *= 1.0 - min(max(node.value("transparency", 0.0), 0.0), 1.0)
    return Visual(checked_name(node), pose, geometry, (red, green, blue, alpha))


def _read_joints(
    node: Node, frames: _Frames, links: dict[str, Link], nested: Sequence[Model]
) -> tuple[Joint, ...]:
    joints = [joint for model in nested for joint in _flattened_joints(model)]
    parent_of = {joint.child: joint.parent for joint in joints}
    for name, child in unique(node.children("joint")).items():
        joint = _read_joint(child, checked_name(child), frames, links)
        if joint.child in parent_of:
            raise child.error(
                f'The link "{joint.child}" is already joined to "{parent_of[joint.child]}"; '
                "a link can have one parent only"
            )
        parent_of[joint.child] = joint.parent
        if _leads_to_itself(joint.child, parent_of):
            raise child.error(f'The joint "{name}" closes a ring of joints, which is not supported')
        joints.append(joint)
    return tuple(joints)


def _leads_to_itself(link: str, parent_of: dict[str, str]) -> bool:
    above = parent_of.get(link)
    while above is not None and above != link:
        above = parent_of.get(above)
    return above == link


def _read_joint(node: Node, name: str, frames: _Frames, links: dict[str, Link]) -> Joint:
    kind = node.attribute("type")
    if kind not in ("fixed", "revolute", "continuous"):
        raise node.error(f'Joints of type "{kind}" are not supported; use fixed or revolute')
    parent, child = node.required("parent"), node.required("child")
    for end in (parent, child):
        if end.text not in links and not (end is parent and end.text == "world"):
            raise end.error(f'The joint "{name}" names the link "{end.text}", which does not exist')
    if parent.text == child.text:
        raise node.error(f'The joint "{name}" joins the link "{child.text}" to itself')
    joint = Joint(
        name=name,
        kind="fixed" if kind == "fixed" else "revolute",
        parent=parent.text,
        child=child.text,
        pose=frames.in_link(node, links[child.text].pose),
    )
    if joint.kind == "fixed":
        return joint
    axis_node = node.required("axis")
    axis = _axis(axis_node, frames, links[joint.child].pose @ joint.pose)
    return _with_axis(axis_node, replace(joint, axis=axis), kind)


def _axis(node: Node, frames: _Frames, joint_in_model: Pose) -> Vector3:
    """Return a joint's axis in the joint's frame, whatever frame the file gives it in."""
    xyz = node.required("xyz")
    axis: Vector3 = unit_vector(xyz, (0.0, 0.0, 1.0))
    given_in = xyz.attribute("expressed_in", "")  # from SDF 1.7 on, in place of the flag
    if node.flag("use_parent_model_frame", False):
        given_in = given_in or "__model__"
    if not given_in:
        return axis
    in_model = rotate(frames.in_model(given_in, xyz).orientation_xyzw, axis)
    return rotate_inverse(joint_in_model.orientation_xyzw, in_model)


def _with_axis(node: Node, joint: Joint, kind: str) -> Joint:
    infinite = float("inf")
    lower, upper = -infinite, infinite
    limits = node.child("limit")
    if limits is not None:
        limits.accept("effort", "velocity", "stiffness", "dissipation")
        lower, upper = limits.limit("lower", -infinite), limits.limit("upper", infinite)
        if lower > upper:
            raise limits.error(f"The lower limit ({lower:g}) is above the upper one ({upper:g})")
    if kind == "continuous":
        lower, upper = -infinite, infinite
    dynamics = node.child("dynamics")
    damping = friction = 0.0
    if dynamics is not None:
        damping = dynamics.value("damping", 0.0, NOT_NEGATIVE)
        friction = dynamics.value("friction", 0.0, NOT_NEGATIVE)
        for tag in ("spring_reference", "spring_stiffness"):
            dynamics.accept_value(tag, *ZERO)
    # Older models write a fixed joint as a hinge whose limits are equal.
    kind = "fixed" if lower == upper == 0.0 else "revolute"
    return replace(
        joint,
        kind=kind,
        lower_rad=lower,
        upper_rad=upper,
        damping=damping,
        friction=friction,
    )


def _flattened_links(model: Model) -> list[Link]:
    return [
        replace(link, name=f"{model.name}::{link.name}", pose=model.pose @ link.pose) for link in model.links
    ]


def _flattened_joints(model: Model) -> list[Joint]:
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
