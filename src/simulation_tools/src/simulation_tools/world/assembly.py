"""From links and joints to rigid parts: links that are joined rigidly move as one body.

Fixed joints connect links rigidly. So do joints that the caller declares rigid, for example rotors whose
spin the airframe model computes. Such links become one part with their common mass, centre of mass and
inertia. Fewer bodies make the physics faster and stiffer. A quadrotor then is one free body, as the flight
controller's theory assumes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import permutations
from typing import Iterable, Sequence

import numpy as np

from simulation_tools.geometry import IDENTITY, Pose, quaternion_from_matrix, rotation_matrix
from simulation_tools.sdf.elements import Collision, Inertial, Joint, Link, Model, Plane, Visual
from simulation_tools.world.shapes.meshes import mesh_of

WORLD_LINK = "world"


@dataclass(frozen=True)
class MassProperties:
    """mass_kg; centre_m: (3,) centre of mass; inertia_kg_m2: (3, 3) about it; all in one frame."""

    mass_kg: float
    centre_m: np.ndarray
    inertia_kg_m2: np.ndarray

    def principal(self) -> tuple[Pose, tuple[float, float, float]]:
        """Return the frame of the principal axes at the centre of mass, and the moments about them.

        The axes are those closest to the frame's own. So a body without products of inertia keeps its axes.
        """
        inertia = self.inertia_kg_m2
        centre = tuple(self.centre_m.tolist())
        off_diagonal = abs(inertia - np.diag(np.diag(inertia))).max()
        if off_diagonal <= 1e-12 * max(abs(np.diag(inertia)).max(), 1e-300):
            return Pose(centre), tuple(np.diag(inertia).tolist())
        moments, axes = np.linalg.eigh(inertia)
        order = _closest_order(axes)
        moments, axes = moments[order], axes[:, order]
        axes = axes * np.where(np.diag(axes) < 0.0, -1.0, 1.0)
        if np.linalg.det(axes) < 0.0:
            axes[:, 2] *= -1.0
        return Pose(centre, quaternion_from_matrix(axes)), tuple(moments.tolist())


def combined(bodies: Iterable[tuple[Inertial, Pose]]) -> MassProperties:
    """Add up inertials, each with the pose of its link in the common frame (parallel axis theorem)."""
    masses, centres, inertias = [], [], []
    for inertial, link_pose in bodies:
        pose = link_pose @ inertial.pose
        turn = rotation_matrix(pose.orientation_xyzw)
        masses.append(inertial.mass_kg)
        centres.append(np.array(pose.position_m))
        inertias.append(turn @ _matrix(inertial.moments_kg_m2) @ turn.T)
    total = math.fsum(masses)
    centre = sum((mass * place for mass, place in zip(masses, centres)), np.zeros(3)) / total
    inertia = np.zeros((3, 3))
    for mass, place, own in zip(masses, centres, inertias):
        arm = place - centre
        inertia += own + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return MassProperties(total, centre, inertia)


@dataclass(frozen=True)
class PlacedCollision:
    """A collision shape and its link; pose: of the shape in the frame of the part."""

    link: str
    collision: Collision
    pose: Pose

    @cached_property
    def inverse(self) -> Pose:
        """Pose of the part's frame in the shape's."""
        return self.pose.inverse()

    @cached_property
    def reach_m(self) -> float:
        """Radius of a sphere about the shape's frame that holds the shape's bounding box; inf for a plane."""
        geometry = self.collision.geometry
        if isinstance(geometry, Plane):
            return math.inf
        return float(np.linalg.norm(np.abs(mesh_of(geometry).vertices).max(axis=0)))


@dataclass(frozen=True)
class PlacedVisual:
    """A visual shape; pose: in the frame of the part."""

    visual: Visual
    pose: Pose


@dataclass(frozen=True)
class Part:
    """Links that move as one.

    pose: of the part's frame in the model frame, all joints at zero. The frame of a base part (parent -1) is
    the model frame. The frame of any other part is that of the joint that carries it. mass: None if it
    cannot move. parent: index of the carrying part in its assembly. weightless: the mass of its links that
    have no weight, None if all have. scripted: of an actor. Nothing pushes it; its script moves it at every
    step.
    """

    pose: Pose
    links: tuple[Link, ...]
    mass: MassProperties | None
    collisions: tuple[PlacedCollision, ...]
    visuals: tuple[PlacedVisual, ...]
    weightless: MassProperties | None = None
    parent: int = -1
    joint: Joint | None = None
    scripted: bool = False


def assemblies(model: Model, rigid_joints: frozenset[str] = frozenset()) -> list[tuple[Part, ...]]:
    """Split a model into independent assemblies of parts, each with its base first, parents before children.

    The first assembly holds the model's first link.

    rigid_joints: names of joints to treat as fixed. A static model is one part that cannot move.
    """
    if model.static:
        part = _part(model, list(model.links), IDENTITY, fixed=True)
        return [(replace(part, scripted=model.script is not None),)]
    groups = _rigid_groups(model, rigid_joints)
    moving = [joint for joint in model.joints if not _is_rigid(joint, rigid_joints)]
    carried = {_group_of(joint.child, groups): joint for joint in moving}
    bases = [group for group in groups if group not in carried]
    result = [tuple(_tree(model, base, groups, carried)) for base in bases]
    home = model.links[0].name
    result.sort(key=lambda parts: not any(link.name == home for part in parts for link in part.links))
    return result


def _tree(
    model: Model, base: frozenset[str], groups: Sequence[frozenset[str]], carried: dict[frozenset[str], Joint]
) -> list[Part]:
    links = {link.name: link for link in model.links}
    parts = [_part(model, [links[name] for name in _in_order(model, base)], IDENTITY, WORLD_LINK in base)]
    indices = {base: 0}
    waiting = list(carried.items())
    while True:
        ready = [(group, joint) for group, joint in waiting if _group_of(joint.parent, groups) in indices]
        if not ready:
            return parts
        for group, joint in ready:
            frame = links[joint.child].pose @ joint.pose
            members = [links[name] for name in _in_order(model, group)]
            indices[group] = len(parts)
            parent = indices[_group_of(joint.parent, groups)]
            parts.append(_part(model, members, frame, False, parent, joint))
        waiting = [(group, joint) for group, joint in waiting if group not in indices]


def _part(
    model: Model, links: list[Link], frame: Pose, fixed: bool, parent: int = -1, joint: Joint | None = None
) -> Part:
    to_frame = frame.inverse()
    weightless = [(link.inertial, to_frame @ link.pose) for link in links if not link.gravity]
    return Part(
        pose=frame,
        links=tuple(links),
        mass=None if fixed else combined((link.inertial, to_frame @ link.pose) for link in links),
        collisions=tuple(
            PlacedCollision(link.name, shape, to_frame @ link.pose @ shape.pose)
            for link in links
            for shape in link.collisions
        ),
        visuals=tuple(
            PlacedVisual(shape, to_frame @ link.pose @ shape.pose) for link in links for shape in link.visuals
        ),
        weightless=None if fixed or not weightless else combined(weightless),
        parent=parent,
        joint=joint,
    )


def _is_rigid(joint: Joint, rigid_joints: frozenset[str]) -> bool:
    return joint.kind == "fixed" or joint.name in rigid_joints


def _rigid_groups(model: Model, rigid_joints: frozenset[str]) -> list[frozenset[str]]:
    """Partition the links' names (and the world) into sets that move together, in the order of the links."""
    group_of = {name: {name} for name in [*(link.name for link in model.links), WORLD_LINK]}
    for joint in model.joints:
        if _is_rigid(joint, rigid_joints):
            merged = group_of[joint.parent] | group_of[joint.child]
            for name in merged:
                group_of[name] = merged
    groups = list(dict.fromkeys(frozenset(group) for group in group_of.values()))
    lonely_world = frozenset({WORLD_LINK})
    hinged = any(joint.parent == WORLD_LINK and not _is_rigid(joint, rigid_joints) for joint in model.joints)
    return [group for group in groups if group != lonely_world or hinged]


def _group_of(name: str, groups: Sequence[frozenset[str]]) -> frozenset[str]:
    return next(group for group in groups if name in group)


def _in_order(model: Model, group: frozenset[str]) -> list[str]:
    return [link.name for link in model.links if link.name in group]


def _matrix(moments: Sequence[float]) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = moments
    return np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))


def _closest_order(axes: np.ndarray) -> list[int]:
    """Order eigenvectors (columns) so that column k points along coordinate axis k as well as it can."""
    return max(map(list, permutations(range(3))), key=lambda order: sum(abs(axes[range(3), order])))
