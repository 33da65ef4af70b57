"""Reader of a world's ``<state>``: where its models are when it begins, in place of their own poses.

Gazebo writes it when a world is saved. All its poses are in the world frame. Models begin at rest here.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Callable

import numpy as np

from simulation_tools.bounds import are_sane
from simulation_tools.geometry import Pose, Vector3
from simulation_tools.sdf.document import Node
from simulation_tools.sdf.elements import Box, Cylinder, Geometry, Joint, Link, Mesh, Model, Sphere
from simulation_tools.sdf.reading import Omissions
from simulation_tools.sdf.safe_xml import SdfError

RESULTS = ("sim_time", "real_time", "wall_time", "iterations", "light", "acceleration", "wrench")
"""Of the moment when the world was saved; they do not say where anything is."""
UNIT_SCALE = (1.0, 1.0, 1.0)
SPEED_AT_REST = 1e-2
"""A speed below it, m/s or rad/s, is a body at rest that trembles."""


def apply_state(
    node: Node | None, models: list[Model], read: Callable[[Node], list[Model]], omissions: Omissions
) -> list[Model]:
    """Return a world's models where a ``<state>`` has them; those it inserts added, those it deletes gone.

    node: the world's first ``<state>``, None if it has none. read: reads the models in ``<insertions>``.
    omissions: of the request. A model whose state is bad stays where it is without one.
    """
    if node is None:
        return models
    node.accept(*RESULTS)
    for insertions in node.children("insertions"):
        insertions.accept("light")
        models = [*models, *read(insertions)]
    gone = {name.text for deletions in node.children("deletions") for name in deletions.children("name")}
    states = omissions.unique(node.children("model"))
    for name in states.keys() - {model.name for model in models}:
        states[name].passed_over()  # of a model that is left out
    placed = []
    for model in models:
        state = states.get(model.name)
        if model.name in gone:
            continue
        try:
            placed.append(model if state is None else _placed(model, state))
        except SdfError as error:
            assert state is not None
            omissions.leave_out(state, error, f'The state of the model "{model.name}"')
            placed.append(model)
    return placed


def _placed(model: Model, state: Node) -> Model:
    """Return a model at the pose and in the size of its state, its loose links where the state has them."""
    pose = _pose_in_world(state) or model.pose
    links_in_world = _links_in_world(state, "")
    nested_in_world = _nested_in_world(state, "")
    scale = _scale(state)
    links = []
    for link in model.links:
        in_world = links_in_world.get(link.name)
        if in_world is None:
            in_world = _carried(link, model, nested_in_world)
        in_model = link.pose if in_world is None else pose.inverse() @ in_world
        if not _is_same(in_model, link.pose) and _hangs_on_a_hinge(link.name, model.joints):
            state.note(f'The joints of the model "{model.name}" begin at zero, not as <state> has them')
            in_model = link.pose
        links.append(link if _is_same(in_model, link.pose) else replace(link, pose=in_model))
    if scale != UNIT_SCALE:
        links = [_scaled(link, scale) for link in links]
    return replace(model, pose=pose, links=tuple(links))


def _pose_in_world(state: Node) -> Pose | None:
    """Return the pose of a model or a link, None if it has none. What else stands there is accepted."""
    state.accept(*RESULTS, "joint", "collision", "visual")
    for scale in state.children_unmarked("scale"):
        if scale.numbers(3) == UNIT_SCALE:
            scale.understood()
    for velocity in state.children_unmarked("velocity"):
        if max(map(abs, velocity.numbers(6))) < SPEED_AT_REST:
            velocity.understood()
    is_placed = bool(state.children_unmarked("pose"))
    return state.pose()[0] if is_placed else None


def _scale(state: Node) -> Vector3:
    """Return by which factors a model's shapes are larger; those of its nested models have no meaning."""
    for scale in state.children_unmarked("scale"):
        x, y, z = scale.numbers(3)
        if min(x, y, z) > 0.0 and are_sane((x, y, z)):
            scale.understood()
            return x, y, z
    return UNIT_SCALE


def _scaled(link: Link, scale: Vector3) -> Link:
    """Return a link with larger shapes. As in Gazebo, they stay where they are, and round ones stay round."""
    return replace(
        link,
        collisions=tuple(
            replace(shape, geometry=_larger(shape.geometry, scale)) for shape in link.collisions
        ),
        visuals=tuple(replace(shape, geometry=_larger(shape.geometry, scale)) for shape in link.visuals),
    )


def _larger(geometry: Geometry, scale: Vector3) -> Geometry:
    x, y, z = scale
    if isinstance(geometry, Box):
        return Box(_product(geometry.size_m, scale))
    if isinstance(geometry, Mesh):
        return replace(geometry, scale=_product(geometry.scale, scale))
    if isinstance(geometry, Cylinder):
        return Cylinder(geometry.radius_m * max(x, y), geometry.length_m * z)
    return Sphere(geometry.radius_m * max(scale)) if isinstance(geometry, Sphere) else geometry


def _product(a: Vector3, b: Vector3) -> Vector3:
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]


def _links_in_world(state: Node, prefix: str) -> dict[str, Pose]:
    """Return the poses of a model's links, also of its nested models' (``inner::link``)."""
    found = {}
    for link in state.children("link"):
        pose = _pose_in_world(link)
        if pose is not None:
            found[prefix + link.attribute("name")] = pose
    for nested in state.children("model"):
        _pose_in_world(nested)
        found.update(_links_in_world(nested, f"{prefix}{nested.attribute('name')}::"))
    return found


def _nested_in_world(state: Node, prefix: str) -> dict[str, Pose]:
    """Return the poses of nested models by their names (``inner``, ``inner::innermost``)."""
    found = {}
    for nested in state.children("model"):
        name = prefix + nested.attribute("name")
        pose = _pose_in_world(nested)
        if pose is not None:
            found[name] = pose
        found.update(_nested_in_world(nested, f"{name}::"))
    return found


def _carried(link: Link, model: Model, nested_in_world: dict[str, Pose]) -> Pose | None:
    """Return the pose in the world of a link that its nested model carries there; None if none does."""
    places = [
        (name, pose)
        for name, pose in model.nested
        if name in nested_in_world and link.name.startswith(f"{name}::")
    ]
    if not places:
        return None
    innermost, pose = max(places, key=lambda place: len(place[0]))
    return nested_in_world[innermost] @ pose.inverse() @ link.pose


def _hangs_on_a_hinge(link: str, joints: tuple[Joint, ...]) -> bool:
    """Whether a joint that moves is between the link and the root of its model."""
    above = {joint.child: joint for joint in joints}
    joint = above.get(link)
    while joint is not None:
        if joint.kind != "fixed":
            return True
        joint = above.get(joint.parent)
    return False


def _is_same(a: Pose, b: Pose) -> bool:
    """Whether two poses differ by no more than a settled body does, 1e-4 m and rad."""
    apart = a.inverse() @ b
    return bool(np.abs((*apart.position_m, *apart.rpy_rad)).max() < 1e-4)
