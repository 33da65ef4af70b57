"""URDF to SDF, as Gazebo's ``spawn_urdf_model`` needs it: the same links and joints, at the angle zero.

A link without inertia is as good as weightless; Gazebo joins it to its neighbour. The root link ``world`` is
the world. What ``<gazebo>`` adds is read in `extensions`.
"""

from __future__ import annotations

from lxml import etree

from simulation_tools.geometry import IDENTITY, Pose
from simulation_tools.sdf.safe_xml import SdfError
from simulation_tools.sdf.urdf.extensions import Parts, extend

SLIGHT_KG, SLIGHT_KG_M2 = "1e-5", "1e-8"
"""Mass and moments of a link without ``<inertial>``."""
KINDS = {"floating": "", "planar": "prismatic"}
"""URDF's joints that SDF calls otherwise; a floating one is none."""
WORLD = "world"
"""Name of the root link that stands for the world, as in Gazebo."""
XACRO = "xacro"


def sdf_of(robot: etree._Element, name: str) -> tuple[etree._Element, list[str]]:
    """Return URDF as SDF, each element with its line of the URDF, and what is done otherwise than it says.

    name: stands for the path in errors. Raises SdfError.
    """
    _refuse_xacro(robot, name)
    joints = [joint for joint in robot.findall("joint") if KINDS.get(joint.get("type", ""), "a") != ""]
    root = _made(None, "sdf", robot, version="1.6")
    model = _made(root, "model", robot, name=robot.get("name", "robot"))
    links = robot.findall("link")
    notes: list[str] = []
    poses, colours = _poses(links, joints, name), _colours(robot)
    parts = Parts(model, {}, {})
    for link in links:
        key = link.get("name", "")
        if key != WORLD:
            parts.links[key] = _add_link(model, link, poses[key], name, colours)
        elif len(link):
            notes.append(
                f'{name}:{link.sourceline}: What the link "{WORLD}" holds is left out, as in Gazebo.'
            )
    for joint in joints:
        parts.joints[joint.get("name", "")] = _add_joint(model, joint)
        if joint.find("mimic") is not None:
            where = f"{name}:{joint.sourceline}"
            notes.append(f'{where}: The joint "{joint.get("name")}" turns freely: <mimic> is not supported.')
    for extension in robot.findall("gazebo"):
        notes += extend(parts, extension, name)
    return root, notes


def _refuse_xacro(robot: etree._Element, name: str) -> None:
    for element in robot.iter(etree.Element):
        space = element.nsmap.get(element.prefix) or "" if element.prefix else ""
        if XACRO in space or str(element.tag).startswith(f"{XACRO}_"):
            sentence = "The file is xacro, not URDF. Convert it first: rosrun xacro xacro FILE > robot.urdf"
            raise SdfError(f"{name}:{element.sourceline}: {sentence}.")


def _made(above: etree._Element | None, tag: str, source: etree._Element, **values: str) -> etree._Element:
    """Return a new element of SDF that has the line of the URDF's element it comes from."""
    made = etree.Element(tag, values) if above is None else etree.SubElement(above, tag, values)
    made.sourceline = source.sourceline
    return made


def _with_text(above: etree._Element, tag: str, source: etree._Element, text: str) -> None:
    _made(above, tag, source).text = text


def _colours(robot: etree._Element) -> dict[str, str]:
    """Return the colours of the materials that have a name, wherever they are given one."""
    found: dict[str, str] = {}
    for material in robot.iter("material"):
        colour = material.find("color")
        if colour is not None:
            found.setdefault(material.get("name", ""), colour.get("rgba", ""))
    return found


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


def _add_link(
    model: etree._Element, link: etree._Element, pose: Pose, name: str, colours: dict[str, str]
) -> etree._Element:
    node = _made(model, "link", link, name=link.get("name", ""))
    _add_pose(node, pose, link)
    _add_inertial(node, link, name)
    for tag in ("collision", "visual"):
        for number, shape in enumerate(link.findall(tag)):
            target = _add_shape(node, tag, f"{tag}_{number}", shape, name)
            if tag == "visual":
                _add_colour(target, shape, colours)
    return node


def _add_inertial(node: etree._Element, link: etree._Element, name: str) -> None:
    inertial = link.find("inertial")
    source = link if inertial is None else inertial
    target = _made(node, "inertial", source)
    moments = {"ixx": SLIGHT_KG_M2, "iyy": SLIGHT_KG_M2, "izz": SLIGHT_KG_M2}
    mass = SLIGHT_KG
    if inertial is not None:
        _add_pose(target, _pose(inertial, name), source)
        found, inertia = inertial.find("mass"), inertial.find("inertia")
        mass = mass if found is None else found.get("value", mass)
        moments = moments if inertia is None else dict(inertia.attrib)
    _with_text(target, "mass", source, mass)
    matrix = _made(target, "inertia", source)
    for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
        _with_text(matrix, key, source, moments.get(key, "0"))


def _add_shape(
    node: etree._Element, tag: str, usual_name: str, shape: etree._Element, name: str
) -> etree._Element:
    target = _made(node, tag, shape, name=shape.get("name") or usual_name)
    _add_pose(target, _pose(shape, name), shape)
    geometry, given = _made(target, "geometry", shape), shape.find("geometry")
    for kind in () if given is None else given:
        made = _made(geometry, str(kind.tag), kind)
        for key, value in kind.attrib.items():
            _with_text(made, "uri" if key == "filename" else key, kind, value)
    return target


def _add_colour(target: etree._Element, shape: etree._Element, colours: dict[str, str]) -> None:
    """Give a visual the colour of its material, which may be another one's of the same name."""
    material = shape.find("material")
    if material is None:
        return
    own = material.find("color")
    rgba = colours.get(material.get("name", "")) if own is None else own.get("rgba", "")
    if rgba is not None:
        _with_text(_made(target, "material", material), "diffuse", material, rgba)


def _add_joint(model: etree._Element, joint: etree._Element) -> etree._Element:
    kind = joint.get("type", "")
    node = _made(model, "joint", joint, name=joint.get("name", ""), type=KINDS.get(kind, kind))
    for end in ("parent", "child"):
        _with_text(node, end, joint, _end(joint, end))
    if kind == "fixed":
        return node
    axis, given = _made(node, "axis", joint), joint.find("axis")
    _with_text(axis, "xyz", joint, "1 0 0" if given is None else given.get("xyz", "1 0 0"))
    for tag in ("limit", "dynamics"):
        found = joint.find(tag)
        if found is not None:
            target = _made(axis, tag, found)
            # In URDF a bound that is not there is 0, in SDF it is infinite.
            bounds = {"lower": "0", "upper": "0"} if tag == "limit" and kind != "continuous" else {}
            for key, value in {**bounds, **found.attrib}.items():
                _with_text(target, str(key), found, str(value))
    return node


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


def _add_pose(node: etree._Element, pose: Pose, source: etree._Element) -> None:
    if pose != IDENTITY:
        numbers = (*pose.position_m, *pose.rpy_rad)
        _with_text(node, "pose", source, " ".join(repr(value) for value in numbers))
