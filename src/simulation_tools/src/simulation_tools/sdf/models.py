"""Reader of ``<model>``: links, joints, nested models, and the frames that their poses are given in."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Callable, Sequence

from simulation_tools.geometry import Pose, Vector3, rotate, rotate_inverse
from simulation_tools.sdf.checks import NOT_NEGATIVE
from simulation_tools.sdf.document import Node
from simulation_tools.sdf.elements import Collision, Geometry, Inertial, Joint, Link, Model, Sensor, Visual
from simulation_tools.sdf.frames import (
    flattened_joints,
    flattened_links,
    flattened_plugins,
    frames_in,
    root_link,
)
from simulation_tools.sdf.plugins import read_plugins
from simulation_tools.sdf.reading import Reading, free_name, note_number
from simulation_tools.sdf.safe_xml import SdfError
from simulation_tools.sdf.sensors import is_supported, read_sensor
from simulation_tools.sdf.shapes import read_geometry, read_inertial, read_material, read_surface, unit_vector

NAME = re.compile(r"[^\s\x00-\x1f]+( [^\s\x00-\x1f]+)*")
MODEL_FRAMES = ("", "__model__")
NO = ("false", "0")
ZERO = ("0", "0.0", "-0.0", "")
MOVING_KINDS = ("revolute", "continuous")
HELD_KINDS = ("fixed", "prismatic", "ball", "universal", "revolute2", "screw", "gearbox")
"""Joints that do not move here. In a model that moves, a note says so of all but the fixed ones."""
JOINT_EXTRAS = ("physics", "thread_pitch", "gearbox_ratio", "gearbox_reference_body")


def read_model(
    node: Node, reading: Reading, static: bool = False, placement_frame: str | None = None
) -> Model:
    """Read a model whole. Its pose may still be relative to a frame around it.

    static: it is, whatever the file says. placement_frame: of an ``<include>`` that gives the pose; empty:
    the model's own. Then the model's pose is that in which this frame is at the origin. None: the file's pose
    counts. Raises SdfError.
    """
    name = checked_name(node)
    node.accept("allow_auto_disable", "enable_wind")
    pose, relative_to = node.pose() if placement_frame is None else (Pose(), "")
    if placement_frame is not None:
        node.accept("pose")
    placement_frame = placement_frame or node.attribute("placement_frame", "")
    static = node.flag("static", False) or static
    nested, lost = _read_nested(node, reading, static)
    frames = _Frames(node, nested, reading)
    pose = pose @ frames.in_model(placement_frame, node).inverse()
    nested = [replace(each, pose=frames.of_nested(each, node), relative_to="") for each in nested]
    links = [_read_link(child, name, frames, reading, static) for name, child in frames.link_nodes.items()]
    links += [link for model in nested for link in flattened_links(model)]
    if not links:
        raise lost[0][1] if lost else node.error(f'The model "{name}" has no <link>')
    for child, error in lost:
        reading.omissions.leave_out(child, error)
    joints = _read_joints(node, frames, {link.name: link for link in links}, nested, reading, static)
    return Model(
        name=name,
        pose=pose,
        static=static,
        links=tuple(links),
        joints=joints,
        plugins=(
            *read_plugins(node, reading.omissions),
            *(plugin for model in nested for plugin in flattened_plugins(model)),
        ),
        source=node.document.name,
        warnings=tuple(warning for model in nested for warning in model.warnings),
        relative_to="" if relative_to == "world" else relative_to,
        nested=tuple(place for model in nested for place in _places_in(model)),
    )


def _places_in(nested: Model) -> list[tuple[str, Pose]]:
    """Return the names and poses, in the outer model's frame, of a nested model and of those in it."""
    inner = [(f"{nested.name}::{name}", nested.pose @ pose) for name, pose in nested.nested]
    return [(nested.name, nested.pose), *inner]


def _read_nested(
    node: Node, reading: Reading, static: bool
) -> tuple[list[Model], list[tuple[Node, SdfError]]]:
    """Read the models inside a model. Return them, and the includes that cannot be followed."""
    nested = [read_model(child, reading, static) for child in node.children("model")]
    lost = []
    for child in node.children("include"):
        try:
            model = reading.include(child, static)
            if model is None:
                raise child.error("A model can include models only")
            nested.append(model)
        except SdfError as error:
            lost.append((child, error))
    return _with_unequal_names(node, nested), lost


def _with_unequal_names(node: Node, nested: list[Model]) -> list[Model]:
    """Return the models inside a model. If a name is taken, the second one gets a number, as in a world."""
    found: dict[str, Model] = {}
    for model in nested:
        name = free_name(model.name, found)
        if name != model.name:
            note_number(node, "model", model.name, name)
        found[name] = replace(model, name=name)
    return list(found.values())


class _Frames:
    """The named frames of a model: links, ``<frame>``s, joints and nested models, resolved on demand.

    If a link and a joint have the same name, the name means the link.
    """

    def __init__(self, model: Node, nested: Sequence[Model], reading: Reading) -> None:
        self.link_nodes = reading.omissions.numbered(model.children("link"))
        self._raw: dict[str, tuple[Node, Pose, str]] = {}
        self._known: dict[str, Pose] = {}
        self.joint_nodes = reading.omissions.unique(model.children("joint"))
        self.frame_nodes = reading.omissions.unique(model.children("frame"))
        self.nested_roots = {each.name: f"{each.name}::{root_link(each).name}" for each in nested}
        for name, node in {**self.joint_nodes, **self.frame_nodes, **self.link_nodes}.items():
            pose, frame = node.pose()
            self._raw[name] = (node, pose, frame or _usual_frame(node))
        for inner in nested:
            self._raw[inner.name] = (model, inner.pose, inner.relative_to)
            for name, pose in frames_in(inner).items():
                self._raw[f"{inner.name}::{name}"] = (model, pose, inner.name)

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

    def of_nested(self, inner: Model, asker: Node) -> Pose:
        """Return the pose of a nested model in the model frame."""
        return self.in_model(inner.relative_to, asker) @ inner.pose

    def link_of(self, name: str) -> str:
        """Return the link that a frame is fixed to; the name itself if it is no ``<frame>`` or nested model.

        From SDF 1.8 on, a joint may name frames in place of links.
        """
        for _ in range(len(self._raw) + 1):  # a ring of frames is told where their poses are read
            if name in self.nested_roots:
                return self.nested_roots[name]
            node = self.frame_nodes.get(name)
            attached_to = "" if node is None else node.attribute("attached_to", "")
            if name in self.link_nodes or not attached_to:
                break
            name = attached_to
        return name

    def in_link(self, node: Node, link: Pose, usual: str = "") -> Pose:
        """Return the pose of an element in its link's frame (link: the link's pose in the model).

        usual: the frame that its pose is in if it names none; empty: the link's.
        """
        pose, frame = node.pose()
        frame = frame or usual
        return pose if not frame else link.inverse() @ self.in_model(frame, node) @ pose


def _usual_frame(node: Node) -> str:
    """Return the frame of a link, ``<frame>`` or joint that does not name one itself."""
    if node.tag == "joint":
        child = node.child("child")
        return "" if child is None or child.is_empty else child.text
    return node.attribute("attached_to", "") if node.tag == "frame" else ""


def checked_name(node: Node) -> str:
    """Return an element's name; SdfError when it cannot be one."""
    name = node.attribute("name")
    if not NAME.fullmatch(name) or name == "world":
        raise node.error(f'"{name}" cannot be the name of a <{node.tag}>')
    return name


def _read_link(node: Node, name: str, frames: _Frames, reading: Reading, static: bool) -> Link:
    node.accept("enable_wind", "must_be_base_link")
    node.accept_value("self_collide", *NO)
    node.accept_value("kinematic", *NO)
    node.accept_empty("velocity_decay")
    checked_name(node)
    pose = frames.in_model(name, node)
    return Link(
        name=name,
        pose=pose,
        inertial=_read_inertial(node, static, reading),
        collisions=_shapes(node, "collision", _read_collision, frames, pose, reading),
        visuals=_shapes(node, "visual", _read_visual, frames, pose, reading),
        gravity=node.flag("gravity", True),
        sensors=_read_sensors(node, frames, pose, reading),
    )


def _read_inertial(node: Node, static: bool, reading: Reading) -> Inertial:
    """Read a link's inertia. A static model has no use for it, so any is taken there."""
    if static:
        node.accept("inertial")
        return read_inertial(None)
    return read_inertial(node.child("inertial"), replaces_bad_moments=reading.omissions.is_lenient)


def _read_sensors(node: Node, frames: _Frames, pose: Pose, reading: Reading) -> tuple[Sensor, ...]:
    found = []
    for child in reading.omissions.unique(node.children_unmarked("sensor")).values():
        try:
            if is_supported(child):
                found.append(read_sensor(child.understood(), frames.in_link(child, pose)))
        except SdfError as error:
            reading.omissions.leave_out(child, error)
    return tuple(found)


def _shapes(node: Node, tag: str, read: Callable, frames: _Frames, link: Pose, reading: Reading) -> tuple:
    """Read the collisions or visuals of a link; skip unsupported kinds of geometry."""
    found = []
    for child in node.children(tag):
        try:
            geometry = read_geometry(child.required("geometry"), reading.model_path)
            shape = read(child, frames.in_link(child, link), geometry)
        except SdfError as error:
            reading.omissions.leave_out(child, error)
            continue
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
    node: Node,
    frames: _Frames,
    links: dict[str, Link],
    nested: Sequence[Model],
    reading: Reading,
    static: bool,
) -> tuple[Joint, ...]:
    joints = [joint for model in nested for joint in flattened_joints(model)]
    parent_of = {joint.child: joint.parent for joint in joints}
    for name, child in frames.joint_nodes.items():
        try:
            joint = _read_joint(child, name, frames, links, static)
            _check_tree(child, joint, parent_of)
        except SdfError as error:
            if not static:  # there no joint moves
                reading.omissions.leave_out(child, error)
            continue
        parent_of[joint.child] = joint.parent
        joints.append(joint)
    return tuple(joints)


def _check_tree(node: Node, joint: Joint, parent_of: dict[str, str]) -> None:
    """Raise SdfError when a joint gives a link a second parent, or closes a ring."""
    if joint.child in parent_of:
        raise node.error(
            f'The link "{joint.child}" is already joined to "{parent_of[joint.child]}"; '
            "a link can have one parent only"
        )
    if _leads_to_itself(joint.child, {**parent_of, joint.child: joint.parent}):
        raise node.error(f'The joint "{joint.name}" closes a ring of joints, which is not supported')


def _leads_to_itself(link: str, parent_of: dict[str, str]) -> bool:
    above = parent_of.get(link)
    while above is not None and above != link:
        above = parent_of.get(above)
    return above == link


def _read_joint(node: Node, name: str, frames: _Frames, links: dict[str, Link], static: bool) -> Joint:
    kind = node.attribute("type")
    if kind not in MOVING_KINDS and kind not in HELD_KINDS:
        raise node.error(f'There are no joints of type "{kind}"')
    parent, child = node.required("parent"), node.required("child")
    if child.text == "world" and kind not in MOVING_KINDS:  # held to the world, whichever way round
        parent, child = child, parent
    above, below = (frames.link_of(end.text) for end in (parent, child))
    for end, link in ((parent, above), (child, below)):
        if link not in links and not (end is parent and link == "world"):
            raise end.error(f'The joint "{name}" names the link "{end.text}", which does not exist')
    if above == below:
        raise node.error(f'The joint "{name}" joins the link "{below}" to itself')
    joint = Joint(
        name=name,
        kind="revolute" if kind in MOVING_KINDS else "fixed",
        parent=above,
        child=below,
        pose=frames.in_link(node, links[below].pose, "" if child.text == below else child.text),
    )
    if static or kind == "fixed":
        node.accept("axis", "axis2", *JOINT_EXTRAS)
        return replace(joint, kind="fixed")
    if joint.kind == "fixed":
        node.accept("axis", "axis2", *JOINT_EXTRAS)
        node.note(f'The joint "{name}" of type {kind} is held: only revolute joints move here')
        return joint
    axis_node = node.child("axis")
    if axis_node is None or not axis_node.children_unmarked("xyz"):
        node.note(f'The joint "{name}" has no <xyz> of its axis: SDF\'s default, z, counts')
    if axis_node is None:
        return joint
    axis = _axis(axis_node, frames, links[joint.child].pose @ joint.pose)
    return _with_axis(axis_node, replace(joint, axis=axis), kind)


def _axis(node: Node, frames: _Frames, joint_in_model: Pose) -> Vector3:
    """Return a joint's axis in the joint's frame, whatever frame the file gives it in."""
    xyz = node.child("xyz")
    axis: Vector3 = unit_vector(xyz, (0.0, 0.0, 1.0))
    given_in = (
        "" if xyz is None else xyz.attribute("expressed_in", "")
    )  # from SDF 1.7 on, in place of the flag
    if node.flag("use_parent_model_frame", node.document.version < (1, 5)):
        given_in = given_in or "__model__"
    if not given_in:
        return axis
    in_model = rotate(frames.in_model(given_in, node).orientation_xyzw, axis)
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
