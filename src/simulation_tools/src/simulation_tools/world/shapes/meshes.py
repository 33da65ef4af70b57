"""Triangle meshes of SDF geometry, for rays and for the collision shapes of mesh files.

Curved primitives are approximated by facets whose corners lie on the true surface, so the mesh is never
outside it and at most `SAGITTA_M` inside.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from simulation_tools.bounds import MAX_MAGNITUDE
from simulation_tools.sdf.elements import (
    Box,
    Cylinder,
    Geometry,
    Heightmap,
    Mesh,
    Model,
    Plane,
    Polyline,
    Sphere,
    World,
)
from simulation_tools.world.shapes.extrusion import extruded
from simulation_tools.world.shapes.mesh_files import read_mesh
from simulation_tools.world.shapes.terrain import MeshError, heights_of
from simulation_tools.world.shapes.triangle_mesh import TriangleMesh

DRAWN_SAGITTA_M = 0.01  # the same for pictures, which take time for each triangle
SAGITTA_M = 0.001  # greatest depth of a facet's middle under the true surface: well below any lidar's noise
GROUNDS = Plane, Heightmap
"""Shapes that cannot move."""
PLANE_HALF_SIZE_M = 2000.0  # stands for an infinite plane; no lidar here sees a tenth as far


def mesh_of(geometry: Geometry, sagitta_m: float = SAGITTA_M) -> TriangleMesh:
    """Return the mesh of a shape in its own frame, round ones as exactly as sagitta_m says.

    Raises MeshError for a file that holds no triangles, and for an outline that crosses itself.
    """
    if isinstance(geometry, Box):
        return _box(geometry)
    if isinstance(geometry, Cylinder):
        return _cylinder(geometry, sagitta_m)
    if isinstance(geometry, Sphere):
        return _sphere(geometry, sagitta_m)
    if isinstance(geometry, Plane):
        return _plane(geometry)
    if isinstance(geometry, Heightmap):
        return _terrain(geometry)
    if isinstance(geometry, Polyline):
        return extruded(geometry)
    return _file(geometry)


def drawn_mesh_of(geometry: Geometry, sagitta_m: float = SAGITTA_M) -> TriangleMesh:
    """Return the mesh of a shape as it is drawn. Only a plane differs: it is drawn in its size."""
    mesh = mesh_of(geometry, sagitta_m)
    if not isinstance(geometry, Plane):
        return mesh
    return TriangleMesh(mesh.vertices * (0.5 * max(geometry.size_m) / PLANE_HALF_SIZE_M), mesh.triangles)


def readable_mesh_of(geometry: Geometry) -> TriangleMesh | None:
    """Return the mesh of a shape as `mesh_of` does; None if its file cannot be used."""
    try:
        return mesh_of(geometry)
    except MeshError:
        return None


def readable(model: Model, drawn: bool = False) -> tuple[Model, list[str]]:
    """Return the model without the shapes whose files cannot be used, and a sentence for each of them.

    drawn: visual shapes count too; those that RViz gets as triangles always do.

    A plane and a heightmap do not move, as in Gazebo; see `_with_fixed_grounds`.
    """
    model, said = _with_fixed_grounds(model)

    def usable(shapes: tuple, everything: bool) -> tuple:
        kept = []
        for shape in shapes:
            try:
                if everything or is_drawn_as_triangles(shape.geometry):
                    mesh_of(shape.geometry)
                kept.append(shape)
            except MeshError as error:
                said.append(f'A shape of the model "{model.name}" is left out: {error}')
        return tuple(kept)

    links = tuple(
        replace(
            link,
            collisions=usable(link.collisions, everything=True),
            visuals=usable(link.visuals, everything=drawn),
        )
        for link in model.links
    )
    return (replace(model, links=links) if said else model), list(dict.fromkeys(said))


def remarks_on_world(world: World) -> tuple[str, ...]:
    """Return in sentences what of a world is not as in its file. The simulator warns of it at its start."""
    shapes = [sentence for model in world.models for sentence in readable(model)[1]]
    return tuple(dict.fromkeys((*shapes, *world.warnings)))


def _with_fixed_grounds(model: Model) -> tuple[Model, list[str]]:
    """Return a model whose planes and heightmaps, if it has any, do not move; and a sentence if it changes.

    Its author forgot `<static>`. If bodies touch nothing else of it, all of the model stays where it is. Else
    it moves, without these shapes.
    """
    collisions = [each for link in model.links for each in link.collisions]
    grounds = [each for each in collisions if isinstance(each.geometry, GROUNDS)]
    if model.static or not grounds:
        return model, []
    kind = type(grounds[0].geometry).__name__.lower()
    if len(grounds) == len(collisions):
        return replace(model, static=True), [
            f'The model "{model.name}" stays where it is, as if it were static: a {kind} does not move.'
        ]
    links = []
    for link in model.links:
        movable = tuple(each for each in link.collisions if not isinstance(each.geometry, GROUNDS))
        links.append(replace(link, collisions=movable))
    return replace(model, links=tuple(links)), [
        f'A shape of the model "{model.name}" is left out: the {kind} "{grounds[0].name}" cannot move, '
        "and the model is not static."
    ]


def is_drawn_as_triangles(geometry: Geometry) -> bool:
    """Whether RViz knows no marker for a shape, so that it gets triangles."""
    return isinstance(geometry, (Heightmap, Polyline)) or (
        isinstance(geometry, Mesh) and bool(geometry.submesh)
    )


def standing_height_m(model: Model) -> float:
    """Return the height of the model frame over the lowest point of the model's collision shapes."""
    heights = [
        mesh_of(collision.geometry).transformed(link.pose @ collision.pose).vertices[:, 2].min()
        for link in model.links
        for collision in link.collisions
    ]
    return -float(min(heights, default=0.0))


def facets(radius_m: float, sagitta_m: float = SAGITTA_M) -> int:
    """Return how many sides keep a polygon within sagitta_m of the circle around it; at least 12 or 24."""
    least = 24 if sagitta_m <= SAGITTA_M else 12
    if radius_m <= sagitta_m:
        return least
    return min(max(least, math.ceil(math.pi / math.acos(1.0 - sagitta_m / radius_m))), 1024)


def _box(box: Box) -> TriangleMesh:
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    # Corner k has x from bit 2, y from bit 1, z from bit 0; faces counter-clockwise seen from outside.
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return TriangleMesh(corners * np.array(box.size_m), _split(quads))


def _cylinder(cylinder: Cylinder, sagitta_m: float) -> TriangleMesh:
    count = facets(cylinder.radius_m, sagitta_m)
    angles = 2.0 * np.pi * np.arange(count) / count
    ring = cylinder.radius_m * np.column_stack((np.cos(angles), np.sin(angles)))
    half = 0.5 * cylinder.length_m
    bottom = np.column_stack((ring, np.full(count, -half)))
    top = np.column_stack((ring, np.full(count, half)))
    vertices = np.concatenate((bottom, top, ((0.0, 0.0, -half), (0.0, 0.0, half))))
    k = np.arange(count)
    after = (k + 1) % count
    side = _split(np.column_stack((k, after, after + count, k + count)))
    caps = (
        np.column_stack((np.full(count, 2 * count), after, k)),
        np.column_stack((np.full(count, 2 * count + 1), k + count, after + count)),
    )
    return TriangleMesh(vertices, np.concatenate((side, *caps)).astype(np.int32))


def _sphere(sphere: Sphere, sagitta_m: float) -> TriangleMesh:
    # On a facet of a latitude-longitude grid both sagittas add up: give each half of the tolerance.
    around = facets(2.0 * sphere.radius_m, sagitta_m)
    rows = max(2, around // 2)
    polar = np.pi * np.arange(1, rows) / rows
    azimuth = 2.0 * np.pi * np.arange(around) / around
    grid = np.stack(
        (
            np.outer(np.sin(polar), np.cos(azimuth)),
            np.outer(np.sin(polar), np.sin(azimuth)),
            np.outer(np.cos(polar), np.ones(around)),
        ),
        axis=-1,
    ).reshape(-1, 3)
    north, south = len(grid), len(grid) + 1
    k = np.arange(around)
    after = (k + 1) % around
    upper = (np.arange(rows - 2) * around)[:, None]
    quads = np.stack(
        np.broadcast_arrays(upper + k, upper + around + k, upper + around + after, upper + after), -1
    )
    last = (rows - 2) * around
    triangles = np.concatenate(
        (
            _split(quads.reshape(-1, 4)),
            np.column_stack((np.full(around, north), k, after)),
            np.column_stack((np.full(around, south), last + after, last + k)),
        )
    )
    vertices = sphere.radius_m * np.concatenate((grid, ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0))))
    return TriangleMesh(vertices, triangles.astype(np.int32))


def _plane(plane: Plane) -> TriangleMesh:
    normal = np.array(plane.normal)
    aside = np.cross(normal, np.eye(3)[np.argmin(abs(normal))])
    aside /= np.linalg.norm(aside)
    along = np.cross(normal, aside)
    corners = [u * aside + v * along for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return TriangleMesh(PLANE_HALF_SIZE_M * np.array(corners), _split(((0, 1, 2, 3),)))


def _terrain(terrain: Heightmap) -> TriangleMesh:
    heights = heights_of(terrain)
    side = len(heights)
    length, width, _ = terrain.size_m
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, side) * length, np.linspace(0.5, -0.5, side) * width)
    vertices = np.column_stack((x.ravel(), y.ravel(), heights.ravel())) + np.array(terrain.position_m)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    # The row below in the picture has the smaller y: counter-clockwise from above.
    quads = np.column_stack((corner, corner + side, corner + side + 1, corner + 1))
    return TriangleMesh(vertices, _split(quads))


def _file(mesh: Mesh) -> TriangleMesh:
    loaded = read_mesh(mesh.path, mesh.submesh, mesh.centred)
    vertices = loaded.vertices * np.array(mesh.scale)
    if np.abs(vertices).max() > MAX_MAGNITUDE:
        raise MeshError(f"{mesh.path}: The mesh is larger than {MAX_MAGNITUDE:g} m.")
    is_mirrored = math.prod(mesh.scale) < 0.0  # its triangles then turn round, so that they face outside
    return TriangleMesh(vertices, loaded.triangles[:, ::-1] if is_mirrored else loaded.triangles)


def _split(quads: ArrayLike) -> np.ndarray:
    """Cut quadrilaterals (n, 4) into triangles (2 n, 3)."""
    corners = np.asarray(quads)
    return np.concatenate((corners[:, (0, 1, 2)], corners[:, (0, 2, 3)])).astype(np.int32)
