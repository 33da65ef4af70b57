"""SDF to URDF: the `robot_description` of a model, so that RViz's RobotModel shows what the simulator flies.

The links have the names of the frames that `tf_publisher` sends, so no robot_state_publisher is needed. If
one runs, it computes the same transforms from the same joint states. In URDF a link's frame is at its joint.
If the joint is elsewhere in SDF, an extra link with the joint's name lies between parent and child.
"""

from __future__ import annotations

import math
from typing import Iterable

from lxml import etree

from simulation_tools.geometry import IDENTITY, Pose
from simulation_tools.sdf.elements import (
    Box,
    Cylinder,
    Geometry,
    Heightmap,
    Inertial,
    Joint,
    Link,
    Mesh,
    Model,
    Plane,
    Polyline,
    Sphere,
)
from simulation_tools.sdf.frames import Frame, model_frames, root_link

PLANE_THICKNESS_M = 0.002
UNLIMITED = 1e3
"""URDF wants effort and velocity limits where SDF needs none."""


def urdf_of(model: Model, base_frame: str = "base_frame", prefix: str = "") -> str:
    """Return a model as URDF. base_frame: name of the model frame. prefix: goes before all other names."""
    robot = etree.Element("robot", name=model.name)
    etree.SubElement(robot, "link", name=base_frame)  # without a mass: KDL wants none in the root
    root = root_link(model)
    joints = {joint.name: joint for joint in model.joints}
    for link in model.links:
        _add_link(robot, link, prefix)
    _add_fixed(robot, base_frame, prefix + root.name, root.pose)
    links = {link.name for link in model.links}
    for frame in model_frames(model):
        if frame.joint is not None:
            _add_moving(robot, frame, frame.joint, prefix)
        elif frame.child not in joints or frame.child in links:  # a joint's own frame is no link
            if frame.child not in links:
                etree.SubElement(robot, "link", name=prefix + frame.child)
            _add_fixed(robot, prefix + frame.parent, prefix + frame.child, frame.pose)
    return etree.tostring(robot, pretty_print=True, encoding="unicode")


def _add_fixed(robot: etree._Element, parent: str, child: str, pose: Pose) -> None:
    _add_joint(robot, f"{child}_fixed", "fixed", parent, child, pose)


def _add_joint(
    robot: etree._Element, name: str, kind: str, parent: str, child: str, pose: Pose
) -> etree._Element:
    joint = etree.SubElement(robot, "joint", name=name, type=kind)
    _add_origin(joint, pose)
    etree.SubElement(joint, "parent", link=parent)
    etree.SubElement(joint, "child", link=child)
    return joint


def _add_moving(robot: etree._Element, frame: Frame, joint: Joint, prefix: str) -> None:
    """Add a revolute joint. The child's frame need not be at the joint."""
    child = prefix + frame.child
    carrier = child if joint.pose == IDENTITY else prefix + joint.name
    kind = "revolute" if math.isfinite(joint.upper_rad - joint.lower_rad) else "continuous"
    node = _add_joint(robot, joint.name, kind, prefix + frame.parent, carrier, frame.pose @ joint.pose)
    etree.SubElement(node, "axis", xyz=_numbers(joint.axis))
    etree.SubElement(node, "dynamics", damping=_number(joint.damping), friction=_number(joint.friction))
    limit = {"effort": _number(UNLIMITED), "velocity": _number(UNLIMITED)}
    if kind == "revolute":
        limit.update(lower=_number(joint.lower_rad), upper=_number(joint.upper_rad))
    etree.SubElement(node, "limit", limit)
    if carrier != child:
        etree.SubElement(robot, "link", name=carrier)
        _add_fixed(robot, carrier, child, joint.pose.inverse())


def _add_link(robot: etree._Element, link: Link, prefix: str) -> None:
    node = etree.SubElement(robot, "link", name=prefix + link.name)
    _add_inertial(node, link.inertial)
    for visual in link.visuals:
        if isinstance(visual.geometry, (Heightmap, Polyline)):
            continue  # URDF knows neither
        shape = _add_shape(node, "visual", visual.name, visual.pose, visual.geometry)
        material = etree.SubElement(shape, "material", name=f"{link.name}/{visual.name}")
        etree.SubElement(material, "color", rgba=_numbers(visual.rgba))
    for collision in link.collisions:
        if not isinstance(collision.geometry, (Heightmap, Polyline)):
            _add_shape(node, "collision", collision.name, collision.pose, collision.geometry)


def _add_inertial(node: etree._Element, inertial: Inertial) -> None:
    parent = etree.SubElement(node, "inertial")
    _add_origin(parent, inertial.pose)
    etree.SubElement(parent, "mass", value=_number(inertial.mass_kg))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    moments = {name: _number(value) for name, value in zip(names, inertial.moments_kg_m2)}
    etree.SubElement(parent, "inertia", moments)


def _add_shape(node: etree._Element, tag: str, name: str, pose: Pose, geometry: Geometry) -> etree._Element:
    shape = etree.SubElement(node, tag, name=name)
    if isinstance(geometry, Plane):  # URDF has no plane: a thin box, its upper side where the plane is
        pose = pose @ geometry.turn_from_z @ Pose((0.0, 0.0, -0.5 * PLANE_THICKNESS_M))
    _add_origin(shape, pose)
    parent = etree.SubElement(shape, "geometry")
    if isinstance(geometry, Box):
        etree.SubElement(parent, "box", size=_numbers(geometry.size_m))
    elif isinstance(geometry, Cylinder):
        size = {"radius": _number(geometry.radius_m), "length": _number(geometry.length_m)}
        etree.SubElement(parent, "cylinder", size)
    elif isinstance(geometry, Sphere):
        etree.SubElement(parent, "sphere", radius=_number(geometry.radius_m))
    elif isinstance(geometry, Plane):
        etree.SubElement(parent, "box", size=_numbers((*geometry.size_m, PLANE_THICKNESS_M)))
    elif isinstance(geometry, Mesh):
        uri = f"file://{geometry.path}"
        etree.SubElement(parent, "mesh", filename=uri, scale=_numbers(geometry.scale))
    return shape


def _add_origin(node: etree._Element, pose: Pose) -> None:
    if pose != IDENTITY:
        etree.SubElement(node, "origin", xyz=_numbers(pose.position_m), rpy=_numbers(pose.rpy_rad))


def _numbers(values: Iterable[float]) -> str:
    return " ".join(map(_number, values))


def _number(value: float) -> str:
    return repr(float(value) + 0.0)  # + 0.0: a minus zero is a zero
