"""Reader of a world's ``<state>``: where its models are when it begins, in place of their own poses.

Gazebo writes it when a world is saved. All its poses are in the world frame. Models begin at rest here.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Callable

import numpy as np

from simulation_tools.geometry import Pose
from simulation_tools.sdf.document import Node
from simulation_tools.sdf.elements import Joint, Model

RESULTS = ("sim_time", "real_time", "wall_time", "iterations", "light", "acceleration", "wrench")
"""Of the moment when the world was saved; they do not say where anything is."""
UNIT_SCALE = ("1 1 1", "1.0 1.0 1.0")
SPEED_AT_REST = 1e-2
"""A speed below it, m/s or rad/s, is a body at rest that trembles."""


def apply_state(node: Node | None, models: list[Model], read: Callable[[Node], list[Model]]) -> list[Model]:
    """Return a world's models where a ``<state>`` has them; those it inserts added, those it deletes gone.

    node: the world's first ``<state>``, None if it has none. read: reads the models in ``<insertions>``.
    """
    if node is None:
        return models
    node.accept(*RESULTS)
    for insertions in node.children("insertions"):
        insertions.accept("light")
        models = [*models, *read(insertions)]
    gone = {name.text for deletions in node.children("deletions") for name in deletions.children("name")}
    states = {state.attribute("name"): state for state in node.children("model")}
    for name in states.keys() - {model.name for model in models}:
        states[name].passed_over()  # of a model that is left out
    return [
        _placed(model, states[model.name]) if model.name in states else model
        for model in models
        if model.name not in gone
    ]


def _placed(model: Model, state: Node) -> Model:
    """Return a model at the pose of its state, with its loose links where the state has them."""
    pose = _pose_in_world(state) or model.pose
    links_in_world = _links_in_world(state, "")
    links = []
    for link in model.links:
        in_world = links_in_world.get(link.name)
        in_model = link.pose if in_world is None else pose.inverse() @ in_world
        if not _is_same(in_model, link.pose) and _hangs_on_a_hinge(link.name, model.joints):
            state.note(f'The joints of the model "{model.name}" begin at zero, not as <state> has them')
            in_model = link.pose
        links.append(link if _is_same(in_model, link.pose) else replace(link, pose=in_model))
    return replace(model, pose=pose, links=tuple(links))


def _pose_in_world(state: Node) -> Pose | None:
    """Return the pose of a model or a link, None if it has none. What else stands there is accepted."""
    state.accept(*RESULTS, "joint", "collision", "visual")
    state.accept_value("scale", *UNIT_SCALE)
    for velocity in state.children_unmarked("velocity"):
        if max(map(abs, velocity.numbers(6))) < SPEED_AT_REST:
            velocity.understood()
    is_placed = bool(state.children_unmarked("pose"))
    return state.pose()[0] if is_placed else None


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
