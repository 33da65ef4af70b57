"""The physical world: models in PyBullet, and the scene that their shapes form for rays.

World frame ENU, model frames FLU, SI units, quaternions xyzw. A model's state is that of its *model frame*.
(PyBullet itself reports the centre of mass.)
"""

from __future__ import annotations

import math
from typing import Iterable, Sequence

import numpy as np

from simulation_tools.bounds import are_sane
from simulation_tools.geometry import Pose, Vector3
from simulation_tools.sdf.elements import Model, World
from simulation_tools.world.assembly import Part, assemblies, combined
from simulation_tools.world.bodies import Body, BodyFactory, part_mesh, visual_mesh
from simulation_tools.world.clearance import Clearances, OwnShape
from simulation_tools.world.contacts import Contact, contacts_of
from simulation_tools.world.drawing import draw
from simulation_tools.world.engine import WorldError, connect, pybullet
from simulation_tools.world.forces import hold_up, push
from simulation_tools.world.kinematics import (
    BodyState,
    carried_state,
    joint_angles_of,
    link_state_of,
    model_frame,
    part_pose,
    place,
    state_of,
)
from simulation_tools.world.overlaps import Overlap, overlaps
from simulation_tools.world.population import Population, SpawnedModel
from simulation_tools.world.rays import PoseSource, RayScene
from simulation_tools.world.scripted_motion import ScriptedMotion
from simulation_tools.world.settings import PhysicsSettings
from simulation_tools.world.shapes.meshes import readable
from simulation_tools.world.shapes.triangle_mesh import TriangleMesh, joined

__all__ = ["BodyState", "Contact", "PhysicsWorld", "WorldError"]


class PhysicsWorld:
    """Bodies under gravity and contact, advanced by a fixed time step.

    Each world has its own PyBullet client, so several can live in one process. Not thread-safe. rays: the
    scene of every collision shape, for lidars; it follows the models as they move, come and go. visuals: the
    same of what is drawn, None unless asked for. settings: of the physics; may be changed between steps
    (dynamic_reconfigure does).
    """

    def __init__(
        self,
        world: World,
        time_step_s: float = 0.004,
        gui: bool = False,
        drawn: bool = False,
        seen: bool = False,
    ) -> None:
        """Build every model of a world. remarks: sentences on models and shapes that are not as in its file.

        gui: show PyBullet's window. drawn: give bodies visual shapes even without the window, for `draw`.
        seen: make `visuals`, for depth cameras and lidars of type gpu_ray.
        """
        self.remarks: list[str] = []
        self.rays = RayScene()
        self.visuals = RayScene() if seen else None
        self._time_us = 0  # since the start or the last reset; scripts follow it
        self._there = Population()
        self._states: dict[str, BodyState] = {}
        self._client = connect(gui)
        self._factory = BodyFactory(self._client, draw=gui or drawn)
        self._clearances = Clearances(self._client, self._there.owner)
        try:
            self.settings = PhysicsSettings(self._client, world.gravity_m_s2, time_step_s)
            self._configure()
            # While a world is built, the window would draw a picture for each new body.
            pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_RENDERING, 0, physicsClientId=self._client)
            for model in world.models:
                self._spawn_what_is_usable(model, gui or drawn or seen)
            self.remarks += dict.fromkeys(self._factory.shapes.remarks)
            pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_RENDERING, 1, physicsClientId=self._client)
        except Exception:
            self.close()
            raise
        for scene in self._scenes():
            scene.commit()

    @property
    def client(self) -> int:
        """PyBullet's number of this world."""
        return self._client

    # -- models ----------------------------------------------------------------------------------------------
    def spawn(self, model: Model, name: str, pose: Pose, rigid_joints: frozenset[str] = frozenset()) -> None:
        """Put a model into the world, its model frame at a pose.

        rigid_joints: joints to treat as fixed. Raises WorldError (or MeshError) when the name is taken or the
        model cannot be built; the world is then as it was.
        """
        if name in self._there.models:
            raise WorldError(f'There is already a model called "{name}".')
        unknown = sorted(rigid_joints - {joint.name for joint in model.joints})
        if unknown:
            raise WorldError(f'The model "{name}" has no joint "{unknown[0]}".')
        parts = assemblies(model, rigid_joints)
        # Read the meshes first, because one may be unreadable.
        meshes = self._meshes(parts)
        bodies = self._factory.create(name, parts, pose)
        mass = combined((link.inertial, link.pose) for link in model.links)
        motion = None if model.script is None else ScriptedMotion(model.script)
        spawned = SpawnedModel(model, rigid_joints, pose, pose, parts, bodies, mass, motion, self._time_us)
        self._there.add(name, spawned)
        self._clearances.forget()
        self._put_into_scenes(name, meshes)
        self._follow_scripts(self._time_us)

    def delete(self, name: str) -> None:
        """Take a model out of the world."""
        for body in self._there.find(name).all_bodies:
            pybullet.removeBody(body.uid, physicsClientId=self._client)
        self._there.remove(name)
        self._clearances.forget()
        self._states.pop(name, None)
        for scene in self._scenes():
            scene.remove(name)

    def model_names(self) -> list[str]:
        """Return the names of the models, oldest first."""
        return list(self._there.models)

    def model(self, name: str) -> Model:
        """Return a model's description."""
        return self._there.find(name).model

    def mass_kg(self, name: str) -> float:
        """Return the mass of all of a model's links."""
        return self._there.find(name).mass.mass_kg

    def inertia(self, name: str) -> np.ndarray:
        """Return the inertia (3, 3) about the centre of mass, model frame axes, joints at zero, kg m2."""
        return self._there.find(name).mass.inertia_kg_m2.copy()

    def centre_of_mass(self, name: str) -> Vector3:
        """Return a model's centre of mass in its model frame, joints at zero."""
        return tuple(self._there.find(name).mass.centre_m.tolist())

    # -- state -----------------------------------------------------------------------------------------------
    def get_state(self, name: str) -> BodyState:
        """Return where a model is and how its frame moves."""
        state = self._states.get(name)
        if state is None:
            base = self._there.movers.get(name)
            state = BodyState(self._there.find(name).pose) if base is None else state_of(self._client, base)
            self._states[name] = state
        return state

    def joint_angles(self) -> dict[str, float]:
        """Return the angle of every joint that the physics moves, rad, by its name, `model::joint`."""
        return {
            f"{name}::{joint}": angle
            for name, bodies in self._there.hinged.items()
            for body in bodies
            for joint, angle in joint_angles_of(self._client, body).items()
        }

    def link_state(self, name: str, link_name: str) -> BodyState:
        """Return where a link is and how it moves, as its joints have turned; WorldError if there is none."""
        spawned = self._there.find(name)
        found = spawned.find_link(link_name)
        if found is None:
            raise WorldError(f'The model "{name}" has no link "{link_name}".')
        part, bodies, index, link = found
        if part.mass is None:
            base = self.get_state(name) if part.scripted else BodyState(spawned.pose)
            return carried_state(base, link.pose)
        return link_state_of(self._client, bodies[0], index - 1, part.pose.inverse() @ link.pose)

    def set_state(self, name: str, state: BodyState) -> None:
        """Set a model's pose and, if it is not fixed, its velocities. Its joints keep their angles."""
        spawned = self._there.find(name)
        numbers = (*state.pose.position_m, *state.linear_velocity_m_s, *state.angular_velocity_rad_s)
        if not all(map(math.isfinite, (*numbers, *state.pose.orientation_xyzw))):
            raise WorldError(f'The new state of "{name}" is not finite.')
        move = state.pose @ self.get_state(name).pose.inverse()
        for parts, bodies in zip(spawned.assemblies, spawned.bodies):
            for body in bodies:
                fixed = parts[0].mass is None
                old = spawned.pose if fixed else model_frame(self._client, body)
                place(self._client, body, move @ old, None if fixed else state)
        spawned.pose = state.pose
        self._states.pop(name, None)
        self._clearances.forget()
        if spawned.base is None:
            self._put_into_scenes(name, self._meshes(spawned.assemblies))

    def apply_wrench(self, name: str, force_n: Sequence[float], torque_nm: Sequence[float]) -> None:
        """Push and turn a model during the next step: at its base part's centre of mass, body axes (FLU)."""
        base = self._there.movers.get(name)
        if base is None:
            self._there.find(name)
            return
        (fx, fy, fz), (tx, ty, tz) = force_n, torque_nm
        if not math.isfinite(fx + fy + fz + tx + ty + tz):
            raise WorldError(f'The wrench on "{name}" is not finite.')
        push(self._client, base, force_n, torque_nm)

    def step(self) -> None:
        """Advance everything by one time step."""
        if self._there.lifts:
            self._hold_up_weightless_parts()
        self._time_us += self.settings.time_step_us
        self._states.clear()
        if self._there.actors:
            self._follow_scripts(self._time_us)
        pybullet.stepSimulation(physicsClientId=self._client)

    def beyond_reason(self) -> str | None:
        """Return a model whose place is NaN, or that is absurdly far or fast; None: there is none."""
        for name in self._there.movers:
            state = self.get_state(name)
            if not are_sane(
                (*state.pose.position_m, *state.linear_velocity_m_s, *state.angular_velocity_rad_s)
            ):
                return name
        return None

    @property
    def has_actors(self) -> bool:
        """Whether a script moves anything."""
        return bool(self._there.actors)

    def place_actors(self, time_s: float) -> None:
        """Put all actors where their scripts have them at a time of the world, until the next step."""
        self._follow_scripts(round(1e6 * time_s))

    # -- contacts and distances ------------------------------------------------------------------------------
    def contacts(self, name: str) -> list[Contact]:
        """Return where a model touches others, as the last step found it."""
        return contacts_of(self._client, name, self._there.find(name).all_bodies, self._there.owner)

    def clearance(
        self, name: str, pose: Pose | None, max_distance_m: float, ignore: Iterable[str] = ("ground_plane",)
    ) -> float:
        """Return the least distance between a model's collision shapes and any other model's.

        pose: test the model at this pose; None: its own pose. Negative inside another shape, inf beyond
        max_distance_m. ignore: names of models that do not count.
        """
        spawned = self._there.find(name)
        shift = Pose() if pose is None else pose @ self.get_state(name).pose.inverse()
        own = [
            OwnShape(shape, shift @ part_pose(self._client, body, index - 1), *sphere)
            for body in spawned.all_bodies
            for index, (shape, sphere) in enumerate(zip(body.shapes, body.spheres))
            if shape >= 0
        ]
        return self._clearances.least(own, frozenset((name, *ignore)), max_distance_m)

    def overlaps(self) -> list[Overlap]:
        """Return pairs of models that are inside each other and of which one can move; the deepest first."""
        return overlaps(self._client, self._there.owner)

    def draw(
        self, eye_m: Vector3, ahead: Vector3, up: Vector3, projection: Sequence[float], size: tuple[int, int]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return what a camera sees, see `drawing.draw`; the world must have been built with `drawn`."""
        return draw(self._client, eye_m, ahead, up, projection, size)

    # -- life ------------------------------------------------------------------------------------------------
    def reset(self) -> None:
        """Put every model back where it was spawned, at rest, as in a world built anew; so do scripts."""
        spawned = list(self._there.models.items())
        pybullet.resetSimulation(physicsClientId=self._client)
        self._factory.shapes.forget()
        self._configure()
        self._there.clear()
        self._states.clear()
        self._time_us = 0
        self._clearances.forget()
        for name, old in spawned:
            self.spawn(old.model, name, old.initial_pose, old.rigid_joints)
        for scene in self._scenes():
            scene.commit()

    def close(self) -> None:
        """End the physics; the world cannot be used afterwards. A second call does nothing."""
        if self._client >= 0:
            self._factory.shapes.close()
            if pybullet.isConnected(self._client):
                pybullet.disconnect(self._client)
            self._client = -1

    # -- inside ----------------------------------------------------------------------------------------------
    def _spawn_what_is_usable(self, model: Model, drawn: bool) -> None:
        """Put a model of the world's file into the world, without what cannot be built of it."""
        usable, said = readable(model, drawn)
        self.remarks += said
        try:
            self.spawn(usable, usable.name, usable.pose)
        except WorldError as error:
            self.remarks.append(f'The model "{model.name}" is left out: {error}')

    def _hold_up_weightless_parts(self) -> None:
        for lifts in self._there.lifts.values():
            for lift in lifts:
                hold_up(self._client, *lift, self.settings.gravity_m_s2)

    def _configure(self) -> None:
        self.settings.apply()
        pybullet.setPhysicsEngineParameter(
            deterministicOverlappingPairs=1, enableFileCaching=0, physicsClientId=self._client
        )

    def _follow_scripts(self, time_us: int) -> None:
        """Put every actor where its script has it at a time."""
        for name, actor in self._there.actors.items():
            assert actor.motion is not None
            state = actor.motion.state(1e-6 * (time_us - actor.began_us))
            if state is None:
                continue
            actor.pose = state.pose
            for body in actor.all_bodies:
                place(self._client, body, state.pose, None)
            self._states[name] = state

    def _scenes(self) -> tuple[RayScene, ...]:
        return (self.rays,) if self.visuals is None else (self.rays, self.visuals)

    def _meshes(self, assemblies: Sequence[Sequence[Part]]) -> list[list[list[TriangleMesh | None]]]:
        """Return the mesh of each part, for each of the scenes."""
        return [
            [[mesh(part) for part in parts] for parts in assemblies]
            for mesh, _ in zip((part_mesh, visual_mesh), self._scenes())
        ]

    def _put_into_scenes(self, name: str, meshes: list[list[list[TriangleMesh | None]]]) -> None:
        for scene, groups in zip(self._scenes(), meshes):
            self._put_into(scene, name, groups)

    def _put_into(self, scene: RayScene, name: str, meshes: list[list[TriangleMesh | None]]) -> None:
        spawned = self._there.models[name]
        standing, moving = [], []
        for parts, bodies, group in zip(spawned.assemblies, spawned.bodies, meshes):
            for index, (part, mesh) in enumerate(zip(parts, group)):
                if mesh is None:
                    continue
                if part.scripted or part.mass is not None:
                    moving.append((mesh, self._pose_source(spawned, bodies[0], index)))
                else:
                    standing.append(mesh.transformed(spawned.pose))
        scene.put(name, joined(standing) if standing else None, moving)

    def _pose_source(self, spawned: SpawnedModel, body: Body, index: int) -> PoseSource:
        """Return what tells where a part of a body is; an actor's only part is where the model is."""
        if spawned.motion is not None:
            return lambda: spawned.pose
        return lambda: part_pose(self._client, body, index - 1)
