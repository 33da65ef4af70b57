"""The models of a world, and those of their bodies that need work at every step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Link, Model
from simulation_tools.world.assembly import MassProperties, Part
from simulation_tools.world.bodies import Body
from simulation_tools.world.engine import WorldError
from simulation_tools.world.scripted_motion import ScriptedMotion


@dataclass
class SpawnedModel:
    """A model in the world.

    pose: of its fixed parts; PyBullet has the poses of the others. motion: of an actor, which began at
    began_us.
    """

    model: Model
    rigid_joints: frozenset[str]
    initial_pose: Pose
    pose: Pose
    assemblies: list[tuple[Part, ...]]
    bodies: list[list[Body]]  # of each assembly
    mass: MassProperties
    motion: ScriptedMotion | None = None
    began_us: int = 0

    @cached_property
    def base(self) -> Body | None:
        """The moving body whose base carries the model frame; None if that base is fixed."""
        return None if self.assemblies[0][0].mass is None else self.bodies[0][0]

    @cached_property
    def all_bodies(self) -> list[Body]:
        """The bodies of all assemblies."""
        return [body for group in self.bodies for body in group]

    def find_link(self, name: str) -> tuple[Part, list[Body], int, Link] | None:
        """Return a link with its part, its assembly's bodies and the part's index; None if there is none."""
        for parts, bodies in zip(self.assemblies, self.bodies):
            for index, part in enumerate(parts):
                for link in part.links:
                    if link.name == name:
                        return part, bodies, index, link
        return None


class Population:
    """The models by name, oldest first, and what follows from them.

    owner: name of the model and body of each PyBullet uid. movers: the bases that move. hinged: bodies with
    joints. lifts: (body, PyBullet's link, mass) of every part that has no weight. actors: the models that a
    script moves.
    """

    def __init__(self) -> None:
        self.models: dict[str, SpawnedModel] = {}
        self.owner: dict[int, tuple[str, Body]] = {}
        # By the model's name. A model without such bodies is not in it
        self.lifts: dict[str, list[tuple[Body, int, MassProperties]]] = {}
        self.hinged: dict[str, list[Body]] = {}
        self.movers: dict[str, Body] = {}
        self.actors: dict[str, SpawnedModel] = {}

    def find(self, name: str) -> SpawnedModel:
        """Return a model; WorldError when there is none of that name."""
        try:
            return self.models[name]
        except KeyError:
            raise WorldError(f'There is no model called "{name}".') from None

    def add(self, name: str, spawned: SpawnedModel) -> None:
        """Take in a model that has been built."""
        self.models[name] = spawned
        bodies = spawned.all_bodies
        self.owner.update((body.uid, (name, body)) for body in bodies)
        hinged = [body for body in bodies if len(body.parts) > 1]
        lifts = [
            (body, index - 1, part.weightless)
            for body in bodies
            for index, part in enumerate(body.parts)
            if part.weightless is not None
        ]
        if spawned.base is not None:
            self.movers[name] = spawned.base
        if spawned.motion is not None:
            self.actors[name] = spawned
        if hinged:
            self.hinged[name] = hinged
        if lifts:
            self.lifts[name] = lifts

    def remove(self, name: str) -> None:
        """Forget a model."""
        for body in self.models.pop(name).all_bodies:
            del self.owner[body.uid]
        for known in (self.lifts, self.hinged, self.movers, self.actors):
            known.pop(name, None)

    def clear(self) -> None:
        """Forget all models."""
        for known in (self.models, self.owner, self.lifts, self.hinged, self.movers, self.actors):
            known.clear()
