"""Gazebo's services on models, by its conventions: reference frames, name collisions, success and a sentence.

A bad request raises nothing: the answer says why it is refused, and the world stays as it is. There is no ROS
here; the node converts the messages.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Sequence

from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Pose, Vector3, rotate, rotate_inverse
from simulation_tools.running.run_loop import RunLoop
from simulation_tools.sdf.elements import Model
from simulation_tools.sdf.parser import PathLike, parse_model
from simulation_tools.simulation import Simulation
from simulation_tools.world.world import BodyState

WORLD_NAMES = ("", "world", "map", "/map")
"""Names of the world frame, as Gazebo accepts them."""

AT_REST = (0.0, 0.0, 0.0)


class ServiceError(SimulationToolsError):
    """A request cannot be fulfilled."""


@dataclass(frozen=True)
class Answer:
    """What a service answers.

    state, time_us: of `get_model_state` only: a model's state, and the time of simulation that it is of.
    names: of `get_world_properties` only.
    """

    success: bool
    status_message: str
    state: BodyState | None = None
    time_us: int = 0
    names: tuple[str, ...] = ()


class GazeboServices:
    """Answers requests of any thread between two steps of a running simulation.

    on_change is called, in the simulation's thread, after a model was added, deleted or moved.
    """

    def __init__(
        self,
        simulation: Simulation,
        loop: RunLoop,
        model_path: Sequence[PathLike] | None = None,
        on_change: Callable[[], None] = lambda: None,
    ) -> None:
        self._simulation = simulation
        self._loop = loop
        self._model_path = model_path
        self._on_change = on_change

    def spawn(self, name: str, xml: str, pose: Pose, reference: str) -> Answer:
        """Put a new model into the world. If the name is empty, the model takes the name in its SDF.

        pose: of the frame that the ``<pose>`` in the SDF is given in, as in Gazebo.
        """

        def parse_and_spawn() -> Answer:
            # Parsed in the caller's thread, so that a long file does not hold up the simulation
            model = parse_model(xml, f"spawn_sdf_model {name}".strip(), self._model_path)
            return self._loop.call(lambda: self._spawn(model, name or model.name, pose, reference))

        return _answer(parse_and_spawn)

    def delete(self, name: str) -> Answer:
        """Take a model out of the world."""
        return self._answer_between_steps(lambda: self._delete(name))

    def get_state(self, name: str, reference: str) -> Answer:
        """Return a model's state relative to an entity, in that entity's axes."""
        return self._answer_between_steps(lambda: self._get_state(name, reference))

    def set_state(self, name: str, state: BodyState, reference: str) -> Answer:
        """Set a model's pose and velocities, given in the axes of the reference."""
        return self._answer_between_steps(lambda: self._set_state(name, state, reference))

    def world_properties(self) -> Answer:
        """Return the names of all models."""
        return self._answer_between_steps(
            lambda: Answer(
                True, "The models of the world.", names=tuple(self._simulation.world.model_names())
            )
        )

    def _answer_between_steps(self, action: Callable[[], Answer]) -> Answer:
        return _answer(lambda: self._loop.call(action))

    def _spawn(self, model: Model, name: str, pose: Pose, reference: str) -> Answer:
        world = self._simulation.world
        if name in world.model_names():
            raise ServiceError(f'Failure - a model named "{name}" already exists.')
        if name in WORLD_NAMES or "::" in name:
            raise ServiceError(f'Failure - "{name}" cannot be the name of a model.')
        world.spawn(model, name, self._state_of(reference).pose @ pose @ model.pose)
        self._on_change()
        return Answer(True, f'Spawned "{name}".' + "".join(f" {warning}" for warning in model.warnings))

    def _delete(self, name: str) -> Answer:
        self._require_model(name)
        if name == self._simulation.uav_name:
            raise ServiceError(f'"{name}" carries the flight controller and cannot be deleted.')
        self._simulation.world.delete(name)
        self._on_change()
        return Answer(True, f'Deleted "{name}".')

    def _get_state(self, name: str, reference: str) -> Answer:
        self._require_model(name.split("::", 1)[0])
        state, origin = self._state_of(name), self._state_of(reference)
        to_origin = origin.pose.orientation_xyzw
        relative = BodyState(
            origin.pose.inverse() @ state.pose,
            rotate_inverse(to_origin, _difference(state.linear_velocity_m_s, origin.linear_velocity_m_s)),
            rotate_inverse(
                to_origin, _difference(state.angular_velocity_rad_s, origin.angular_velocity_rad_s)
            ),
        )
        sentence = f'State of "{name}" relative to "{reference or "world"}".'
        return Answer(True, sentence, relative, self._simulation.time_us)

    def _set_state(self, name: str, state: BodyState, reference: str) -> Answer:
        self._require_model(name)
        origin = self._state_of(reference).pose
        self._simulation.world.set_state(
            name,
            BodyState(
                origin @ state.pose,
                rotate(origin.orientation_xyzw, state.linear_velocity_m_s),
                rotate(origin.orientation_xyzw, state.angular_velocity_rad_s),
            ),
        )
        self._simulation.models_moved()
        self._on_change()
        return Answer(True, f'Set the state of "{name}".')

    def _require_model(self, name: str) -> None:
        names = self._simulation.world.model_names()
        if name not in names:
            raise ServiceError(f'There is no model "{name}"; there are: {", ".join(names) or "none"}.')

    def _state_of(self, entity: str) -> BodyState:
        """Return the state of a model, a link (`model::link`) or the world, in the world frame."""
        if entity in WORLD_NAMES:
            return BodyState(Pose.identity(), AT_REST, AT_REST)
        model_name, _, link_name = entity.partition("::")
        self._require_model(model_name)
        world = self._simulation.world
        return world.link_state(model_name, link_name) if link_name else world.get_state(model_name)


def _answer(action: Callable[[], Answer]) -> Answer:
    try:
        return action()
    except SimulationToolsError as error:
        return Answer(False, str(error))


def _difference(a: Vector3, b: Vector3) -> Vector3:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])
