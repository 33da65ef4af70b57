"""Readers of the leaves of a link: shapes, inertia, materials."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Sequence

from simulation_tools.bounds import MAX_MAGNITUDE, are_sane
from simulation_tools.geometry import Vector3
from simulation_tools.sdf import uri
from simulation_tools.sdf.checks import LENGTH, NOT_NEGATIVE, POSITIVE
from simulation_tools.sdf.document import Node
from simulation_tools.sdf.elements import (
    DEFAULT_INERTIAL,
    DEFAULT_SURFACE,
    Box,
    Cylinder,
    Geometry,
    Heightmap,
    Inertial,
    Mesh,
    Plane,
    Polyline,
    Rgba,
    Sphere,
    Surface,
)
from simulation_tools.sdf.safe_xml import SdfError

KINDS = ("box", "cylinder", "sphere", "plane", "mesh", "heightmap", "polyline")
PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff")
BALL_RADIUS_M = 0.1
"""Of a ball that stands for a body whose moments make no sense."""
WHOLE_MESH = "__default__"
"""Gazebo's name for no submesh."""
MESH_SUFFIXES = (".stl", ".obj", ".dae")
DEFAULT_COLOUR: Rgba = (0.7, 0.7, 0.7, 1.0)
# Diffuse colours of Gazebo's own material scripts (media/materials/scripts/gazebo.material) in common use.
GAZEBO_COLOURS: dict[str, Rgba] = {
    "Gazebo/Grey": (0.7, 0.7, 0.7, 1.0),
    "Gazebo/DarkGrey": (0.175, 0.175, 0.175, 1.0),
    "Gazebo/White": (1.0, 1.0, 1.0, 1.0),
    "Gazebo/FlatBlack": (0.1, 0.1, 0.1, 1.0),
    "Gazebo/Black": (0.0, 0.0, 0.0, 1.0),
    "Gazebo/Red": (1.0, 0.0, 0.0, 1.0),
    "Gazebo/Green": (0.0, 1.0, 0.0, 1.0),
    "Gazebo/Blue": (0.0, 0.0, 1.0, 1.0),
    "Gazebo/Yellow": (1.0, 1.0, 0.0, 1.0),
    "Gazebo/Orange": (1.0, 0.5, 0.0, 1.0),
    "Gazebo/Wood": (0.55, 0.38, 0.22, 1.0),
}


def read_geometry(node: Node, model_path: Sequence[Path]) -> Geometry | None:
    """Read ``<geometry>``; the mesh file, if any, must exist.

    Returns None for ``<empty/>`` and for unsupported kinds, which the document's warning names.
    """
    node.accept("empty")
    if not node.children_unmarked(*KINDS) and not node.is_leaf:
        return None
    outlines = node.children("polyline")
    if outlines and len(outlines) == len(node.children_unmarked(*KINDS)):
        return _read_polyline(outlines)
    kind = node.one_of(*KINDS)
    if kind.tag == "box":
        return Box(_size(kind))
    if kind.tag == "cylinder":
        return Cylinder(_length(kind, "radius"), _length(kind, "length"))
    if kind.tag == "sphere":
        return Sphere(_length(kind, "radius"))
    if kind.tag == "plane":
        size = kind.child("size")
        length, width = (1.0, 1.0) if size is None else size.numbers(2)
        return Plane(unit_vector(kind.child("normal"), (0.0, 0.0, 1.0)), (length, width))
    return _read_heightmap(kind, model_path) if kind.tag == "heightmap" else _read_mesh(kind, model_path)


def _read_polyline(nodes: Sequence[Node]) -> Polyline:
    """Read the outlines of one shape. As in Gazebo, the first one has the height of all."""
    outlines = []
    for node in nodes:
        points = [point.numbers(2) for point in node.children("point")]
        if not are_sane([number for point in points for number in point]):
            raise node.error(f"<point> must hold numbers up to {MAX_MAGNITUDE:g}")
        if len(set(points)) < 3:
            raise node.error("<polyline> needs three different points")
        outlines.append(tuple((x, y) for x, y in points))
    for node in nodes[1:]:
        node.accept("height")
    return Polyline(tuple(outlines), nodes[0].value("height", 1.0, LENGTH))


def _read_heightmap(node: Node, model_path: Sequence[Path]) -> Heightmap:
    node.accept("texture", "blend", "use_terrain_paging", "sampling")
    path, location = _read_file(node, model_path, "heightmap", PICTURE_SUFFIXES)
    size = node.child("size")
    place = node.vector("pos", (0.0, 0.0, 0.0))
    if not are_sane(place):
        raise node.error(f"<pos> must hold numbers up to {MAX_MAGNITUDE:g}")
    return Heightmap(path, location, (1.0, 1.0, 1.0) if size is None else _positive_vector(size), place)


def _read_file(node: Node, model_path: Sequence[Path], what: str, suffixes: tuple) -> tuple[str, str]:
    """Return the absolute path of the file that a `<uri>` names, and the uri."""
    location = node.required("uri")
    try:
        path = uri.resolve(location.text, model_path, node.document.folder)
    except uri.UriError as error:
        raise location.error(f"The {what} cannot be loaded: {error}") from None
    if path.suffix.lower() not in suffixes or not path.is_file():
        raise location.error(f'"{location.text}" is not a {what} of a known kind ({", ".join(suffixes)})')
    return str(path), location.text


def _read_mesh(node: Node, model_path: Sequence[Path]) -> Mesh:
    path, location = _read_file(node, model_path, "mesh", MESH_SUFFIXES)
    scale, part = node.child("scale"), node.child("submesh")
    factors = (1.0, 1.0, 1.0) if scale is None else _factors(scale)
    name = None if part is None else part.child("name")
    if part is None or name is None or name.text == WHOLE_MESH:
        return Mesh(path, location, factors)
    return Mesh(path, location, factors, name.text, part.flag("center", False))


def read_inertial(node: Node | None, replaces_bad_moments: bool = False) -> Inertial:
    """Read ``<inertial>``; SDF's default is one kilogram and unit moments.

    replaces_bad_moments: moments that no body can have are replaced, and a note says so; else refused.
    """
    if node is None:
        return DEFAULT_INERTIAL
    pose, frame = node.pose()
    if frame:
        raise node.error("The <pose> of <inertial> cannot be given in another frame")
    if node.attribute("auto", "false").lower() in ("true", "1"):
        node.note("Inertia is not computed of the shapes (auto): what <mass> and <inertia> say counts")
    mass = node.value("mass", 1.0, POSITIVE)
    inertia = node.child("inertia")
    if inertia is None:
        return replace(DEFAULT_INERTIAL, mass_kg=mass, pose=pose)
    try:
        return Inertial(mass, pose, _read_moments(inertia))
    except SdfError as error:
        if not replaces_bad_moments:
            raise
        inertia.passed_over()
        node.document.note(f"{error} The moments of a ball with a radius of {BALL_RADIUS_M:g} m count.")
        moment = 0.4 * mass * BALL_RADIUS_M**2
        return Inertial(mass, pose, (moment, moment, moment, 0.0, 0.0, 0.0))


def _read_moments(inertia: Node) -> tuple[float, float, float, float, float, float]:
    """Return ixx, iyy, izz, ixy, ixz, iyz in kg m2."""
    xx, yy, zz = (inertia.value(tag, 1.0, POSITIVE) for tag in ("ixx", "iyy", "izz"))
    xy, xz, yz = (inertia.value(tag, 0.0) for tag in ("ixy", "ixz", "iyz"))
    if not _positive_definite(xx, yy, zz, xy, xz, yz):
        raise inertia.error("The inertia matrix is not positive definite, so no body can have it")
    return xx, yy, zz, xy, xz, yz


def _positive_definite(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> bool:
    # Sylvester's criterion: every leading minor is positive.
    determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    return xx > 0.0 and xx * yy - xy * xy > 0.0 and determinant > 0.0


def read_surface(node: Node | None) -> Surface:
    """Read ``<surface>``: Coulomb friction (ODE's mu) and restitution."""
    if node is None:
        return DEFAULT_SURFACE
    node.accept_empty("contact", "bounce", "friction")
    friction, restitution = DEFAULT_SURFACE.friction, DEFAULT_SURFACE.restitution
    outer = node.child("friction")
    ode = outer.child("ode") if outer is not None else None
    if ode is not None:
        friction = ode.value("mu", friction)
        if friction < 0.0:
            ode.note(f"<mu> must be zero or positive, not {friction:g}; {DEFAULT_SURFACE.friction:g} counts")
            friction = DEFAULT_SURFACE.friction
        # PyBullet has one coefficient. If a second one differs, the warning names it.
        for second in ode.children_unmarked("mu2"):
            if second.checked_number() == friction:
                second.understood()
    bounce = node.child("bounce")
    if bounce is not None:
        restitution = bounce.value("restitution_coefficient", restitution, NOT_NEGATIVE)
    return Surface(friction, min(restitution, 1.0))


def read_material(node: Node | None) -> Rgba:
    """Read a visual's ``<material>``: its diffuse (else ambient) colour, or a Gazebo script's."""
    if node is None:
        return DEFAULT_COLOUR
    node.accept("specular", "emissive", "lighting")
    ambient, diffuse, script = node.child("ambient"), node.child("diffuse"), node.child("script")
    colour = diffuse or ambient
    if script is not None:
        script.accept("uri")
        names = script.children_unmarked("name")
        if names and names[0].text in GAZEBO_COLOURS:
            names[0].understood()
            return GAZEBO_COLOURS[names[0].text] if colour is None else read_colour(colour)
    return DEFAULT_COLOUR if colour is None else read_colour(colour)


def read_colour(node: Node) -> Rgba:
    """Read red, green, blue and (optionally) alpha, each 0 to 1."""
    if len(node.text.split()) == 4:
        red, green, blue, alpha = node.numbers(4)
        return red, green, blue, alpha
    red, green, blue = node.numbers(3)
    return red, green, blue, 1.0


def unit_vector(node: Node | None, default: Vector3) -> Vector3:
    """Read a direction and scale it to unit length."""
    if node is None:
        return default
    x, y, z = node.numbers(3)
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-9:
        raise node.error(f"<{node.tag}> must not be the zero vector")
    return (x / length, y / length, z / length)


def _factors(node: Node) -> Vector3:
    """Read the factors of a mesh; a negative one mirrors it."""
    x, y, z = node.numbers(3)
    if 0.0 in (x, y, z) or not are_sane((x, y, z)):
        bounds = f"numbers other than 0, up to {MAX_MAGNITUDE:g}"
        raise node.error(f"<{node.tag}> must hold {bounds}, not {x:g} {y:g} {z:g}")
    return (x, y, z)


def _size(kind: Node) -> Vector3:
    """Return the sides of a box, m."""
    node = kind.child("size")
    if node is not None and not node.is_empty:
        return _positive_vector(node)
    kind.note("The <box> has no <size>: SDF's default of 1 m counts")
    return (1.0, 1.0, 1.0)


def _length(kind: Node, tag: str) -> float:
    """Return a length of a round shape, m."""
    node = kind.child(tag)
    if node is not None and not node.is_empty:
        return node.checked_number(LENGTH)
    kind.note(f"The <{kind.tag}> has no <{tag}>: SDF's default of 1 m counts")
    return 1.0


def _positive_vector(node: Node) -> Vector3:
    x, y, z = node.numbers(3)
    if min(x, y, z) <= 0.0 or not are_sane((x, y, z)):
        bounds = f"positive numbers only, up to {MAX_MAGNITUDE:g}"
        raise node.error(f"<{node.tag}> must hold {bounds}, not {x:g} {y:g} {z:g}")
    return (x, y, z)
