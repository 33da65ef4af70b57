"""URDF to SDF, as Gazebo's ``spawn_urdf_model`` needs it: the same links and joints, at the angle zero.

``<gazebo>`` extensions go into the model or the link that they refer to. A link without inertia is as good as
weightless; Gazebo joins it to its neighbour.
"""

from __future__ import annotations

from lxml import etree

from simulation_tools.geometry import IDENTITY, Pose
from simulation_tools.sdf.safe_xml import SdfError, parse_xml

SLIGHT_KG, SLIGHT_KG_M2 = "1e-5", "1e-8"
"""Mass and moments of a link without ``<inertial>``."""
KINDS = {"floating": "", "planar": "prismatic"}
"""URDF's joints that SDF calls otherwise; a floating one is none."""


def is_urdf(text: bytes) -> bool:
    """Whether a text is URDF rather than SDF: its first element is a robot."""
    start = text.find(b"<robot")
    return start >= 0 and b"<sdf" not in text[:start]


def sdf_of(text: bytes, name: str) -> bytes:
    """Return URDF as SDF. name: stands for the path in errors. Raises SdfError."""
    robot = parse_xml(text, name)
    if robot.tag != "robot":
        raise SdfError(f"{name}:1: The file must start with <robot>, not <{robot.tag}>.")
    joints = [joint for joint in robot.findall("joint") if KINDS.get(joint.get("type", ""), "a") != ""]
    root = etree.Element("sdf", version="1.6")
    model = etree.SubElement(root, "model", name=robot.get("name", "robot"))
    poses = _poses(robot.findall("link"), joints, name)
    links = {}
    for link in robot.findall("link"):
        links[link.get("name")] = _add_link(model, link, poses[link.get("name")], name)
    for joint in joints:
        _add_joint(model, joint)
    for extension in robot.findall("gazebo"):
        links.get(extension.get("reference"), model).extend(_extensions(extension))
    return etree.tostring(root)


def _poses(links: list[etree._Element], joints: list[etree._Element], name: str) -> dict[str, Pose]:
    """Return each link's pose in the model's frame, which is that of the link without a parent."""
    above = {_end(joint, "child"): (_end(joint, "parent"), _pose(joint, name)) for joint in joints}
    poses: dict[str, Pose] = {}
    for link in links:
        chain, at = IDENTITY, link.get("name", "")
        for _ in range(len(links) + 1):
            if at not in above:
                break
            at, step = above[at]
            chain = step @ chain
        else:
            raise SdfError(f'{name}:{link.sourceline}: The joints above the link "{at}" form a ring.')
        poses[link.get("name", "")] = chain
    return poses


def _add_link(model: etree._Element, link: etree._Element, pose: Pose, name: str) -> etree._Element:
    node = etree.SubElement(model, "link", name=link.get("name", ""))
    _add_pose(node, pose)
    _add_inertial(node, link.find("inertial"), name)
    for tag in ("collision", "visual"):
        for number, shape in enumerate(link.findall(tag)):
            _add_shape(node, tag, f"{tag}_{number}", shape, name)
    return node


def _add_inertial(node: etree._Element, inertial: etree._Element | None, name: str) -> None:
    target = etree.SubElement(node, "inertial")
    moments = {"ixx": SLIGHT_KG_M2, "iyy": SLIGHT_KG_M2, "izz": SLIGHT_KG_M2}
    mass = SLIGHT_KG
    if inertial is not None:
        _add_pose(target, _pose(inertial, name))
        found, inertia = inertial.find("mass"), inertial.find("inertia")
        mass = mass if found is None else found.get("value", mass)
        moments = moments if inertia is None else dict(inertia.attrib)
    etree.SubElement(target, "mass").text = mass
    matrix = etree.SubElement(target, "inertia")
    for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
        etree.SubElement(matrix, key).text = moments.get(key, "0")


def _add_shape(node: etree._Element, tag: str, usual_name: str, shape: etree._Element, name: str) -> None:
    target = etree.SubElement(node, tag, name=shape.get("name") or usual_name)
    _add_pose(target, _pose(shape, name))
    geometry = etree.SubElement(target, "geometry")
    for kind in shape.find("geometry") if shape.find("geometry") is not None else ():
        made = etree.SubElement(geometry, str(kind.tag))
        for key, value in kind.attrib.items():
            etree.SubElement(made, "uri" if key == "filename" else key).text = value
    colour = shape.find("material/color")
    if tag == "visual" and colour is not None:
        material = etree.SubElement(target, "material")
        etree.SubElement(material, "diffuse").text = colour.get("rgba", "")


def _add_joint(model: etree._Element, joint: etree._Element) -> None:
    kind = joint.get("type", "")
    node = etree.SubElement(model, "joint", name=joint.get("name", ""), type=KINDS.get(kind, kind))
    for end in ("parent", "child"):
        etree.SubElement(node, end).text = _end(joint, end)
    if kind == "fixed":
        return
    axis, given = etree.SubElement(node, "axis"), joint.find("axis")
    etree.SubElement(axis, "xyz").text = "1 0 0" if given is None else given.get("xyz", "1 0 0")
    for tag in ("limit", "dynamics"):
        found = joint.find(tag)
        if found is not None:
            target = etree.SubElement(axis, tag)
            for key, value in found.attrib.items():
                etree.SubElement(target, key).text = value


def _extensions(extension: etree._Element) -> list[etree._Element]:
    """Return the SDF elements of a ``<gazebo>`` element; those of materials and contacts are not SDF."""
    return [
        child for child in extension if child.tag in ("sensor", "plugin", "static", "gravity", "self_collide")
    ]


def _end(joint: etree._Element, tag: str) -> str:
    found = joint.find(tag)
    return "" if found is None else found.get("link", "")


def _pose(element: etree._Element, name: str) -> Pose:
    origin = element.find("origin")
    if origin is None:
        return IDENTITY
    words = [*origin.get("xyz", "0 0 0").split(), *origin.get("rpy", "0 0 0").split()]
    try:
        x, y, z, roll, pitch, yaw = map(float, words)
        return Pose.from_xyz_rpy(x, y, z, roll, pitch, yaw)
    except ValueError:
        where = f"{name}:{origin.sourceline}"
        raise SdfError(f"{where}: <origin> must hold three numbers in xyz and three in rpy.") from None


def _add_pose(node: etree._Element, pose: Pose) -> None:
    if pose != IDENTITY:
        etree.SubElement(node, "pose").text = " ".join(
            repr(value) for value in (*pose.position_m, *pose.rpy_rad)
        )
