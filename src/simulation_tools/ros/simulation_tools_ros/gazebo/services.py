"""Gazebo's services, as the node `gazebo` serves them."""

from __future__ import annotations

from typing import Any, Callable

import rospy
from gazebo_msgs import srv
from gazebo_msgs.msg import ModelState
from std_srvs.srv import (
    Empty,
    EmptyResponse,
    SetBool,
    SetBoolRequest,
    SetBoolResponse,
    Trigger,
    TriggerRequest,
    TriggerResponse,
)

from simulation_tools.errors import SimulationToolsError
from simulation_tools.running.gazebo_services import Answer, GazeboServices
from simulation_tools.running.run_loop import RunLoop
from simulation_tools.simulation import Simulation
from simulation_tools.srv import NodLidar, NodLidarRequest, NodLidarResponse
from simulation_tools.vehicle.nod import Nod
from simulation_tools.world.world import BodyState
from simulation_tools_ros import conversions
from simulation_tools_ros.gazebo.output import GazeboOutput


class Services:
    """Converts requests and answers; `GazeboServices` does the work, between two steps.

    Serves: ~pause_physics, ~unpause_physics, ~reset_simulation, ~reset_world, ~spawn_sdf_model,
    ~spawn_urdf_model, ~delete_model,
    ~get_model_state, ~set_model_state, ~get_world_properties, ~level_lidar, ~nod_lidar,
    ~swap_battery. Subscribes: ~set_model_state.
    """

    def __init__(
        self,
        simulation: Simulation,
        loop: RunLoop,
        output: GazeboOutput,
        reset: Callable[[], None],
        pause: Callable[[bool], None],
        show_pause: Callable[[bool], None],
    ) -> None:
        """Offer the services.

        Args:
            simulation: what the services read and change.
            loop: runs every change between two steps.
            output: publishes the world's visuals after a change.
            reset: resets the whole simulation.
            pause: pauses or resumes it.
            show_pause: shows a pause to dynamic_reconfigure's clients.
        """
        self._simulation = simulation
        self._loop = loop
        self._output = output
        self._reset = reset
        self._pause = pause
        self._show_pause = show_pause
        self._services = GazeboServices(simulation, loop, on_change=output.publish_visuals)
        rospy.Subscriber("~set_model_state", ModelState, self._on_set_model_state, queue_size=10)
        self._advertise()

    def _advertise(self) -> None:
        for name, service_class, handler in (
            ("~pause_physics", Empty, lambda _: self._set_paused(True)),
            ("~unpause_physics", Empty, lambda _: self._set_paused(False)),
            ("~reset_simulation", Empty, lambda _: self._between_steps(self._reset)),
            ("~reset_world", Empty, lambda _: self._between_steps(self._reset_world)),
            ("~spawn_sdf_model", srv.SpawnModel, self._on_spawn),
            ("~spawn_urdf_model", srv.SpawnModel, self._on_spawn),  # as in Gazebo, each takes both forms
            ("~delete_model", srv.DeleteModel, self._on_delete),
            ("~get_model_state", srv.GetModelState, self._on_get_state),
            ("~set_model_state", srv.SetModelState, self._on_set_state),
            ("~get_world_properties", srv.GetWorldProperties, self._on_get_world),
            ("~level_lidar", SetBool, self._on_level_lidar),
            ("~nod_lidar", NodLidar, self._on_nod_lidar),
            ("~swap_battery", Trigger, self._on_swap_battery),
        ):
            rospy.Service(name, service_class, handler)

    # -- services of the whole simulation --------------------------------------------------------------------

    def _between_steps(self, action: Callable[[], None]) -> EmptyResponse:
        """Run an action in the simulation's thread. An Empty service can report an error only in the log."""
        try:
            self._loop.call(action)
        except SimulationToolsError as error:
            rospy.logerr(str(error))
        return EmptyResponse()

    def _set_paused(self, paused: bool) -> EmptyResponse:
        response = self._between_steps(lambda: self._pause(paused))
        self._show_pause(paused)
        return response

    def _reset_world(self) -> None:
        self._simulation.reset_poses()
        self._output.publish_visuals()

    # -- services on models ----------------------------------------------------------------------------------

    def _on_spawn(self, request: srv.SpawnModelRequest) -> srv.SpawnModelResponse:
        return _respond(
            srv.SpawnModelResponse,
            lambda: self._services.spawn(
                request.model_name,
                request.model_xml,
                conversions.gazebo_pose_from_message(request.initial_pose),
                request.reference_frame,
            ),
        )

    def _on_delete(self, request: srv.DeleteModelRequest) -> srv.DeleteModelResponse:
        return _respond(srv.DeleteModelResponse, lambda: self._services.delete(request.model_name))

    def _on_get_state(self, request: srv.GetModelStateRequest) -> srv.GetModelStateResponse:
        answer = self._services.get_state(request.model_name, request.relative_entity_name)
        response = srv.GetModelStateResponse(success=answer.success, status_message=answer.status_message)
        response.header.frame_id = request.relative_entity_name
        if answer.state is not None:
            response.header.stamp = conversions.stamp(answer.time_us)
            response.pose = conversions.pose_message(answer.state.pose)
            response.twist = conversions.twist_message(
                answer.state.linear_velocity_m_s, answer.state.angular_velocity_rad_s
            )
        return response

    def _on_set_state(self, request: srv.SetModelStateRequest) -> srv.SetModelStateResponse:
        return _respond(srv.SetModelStateResponse, lambda: self._set_state(request.model_state))

    def _on_set_model_state(self, message: ModelState) -> None:
        response = _respond(srv.SetModelStateResponse, lambda: self._set_state(message))
        if not response.success:
            rospy.logwarn_throttle(5.0, f"/gazebo/set_model_state: {response.status_message}")

    def _set_state(self, message: ModelState) -> Answer:
        pose = conversions.gazebo_pose_from_message(message.pose)
        state = BodyState(pose, *conversions.twist_from_message(message.twist))
        return self._services.set_state(message.model_name, state, message.reference_frame)

    def _on_get_world(self, _request: srv.GetWorldPropertiesRequest) -> srv.GetWorldPropertiesResponse:
        answer = self._services.world_properties()
        return srv.GetWorldPropertiesResponse(
            sim_time=1e-6 * self._simulation.time_us,
            model_names=answer.names,
            rendering_enabled=False,
            success=answer.success,
            status_message=answer.status_message,
        )

    def _on_level_lidar(self, request: SetBoolRequest) -> SetBoolResponse:
        try:
            self._loop.call(lambda: self._simulation.set_level_lidar(request.data))
        except SimulationToolsError as error:
            return SetBoolResponse(False, str(error))
        return SetBoolResponse(True, f"The lidar is {'kept level' if request.data else 'fixed'}.")

    def _on_nod_lidar(self, request: NodLidarRequest) -> NodLidarResponse:
        try:
            nod = Nod(request.amplitude, request.period, request.sweeps)
            self._loop.call(lambda: self._simulation.nod_lidar(nod))
        except SimulationToolsError as error:
            return NodLidarResponse(False, str(error))
        if nod.amplitude_rad == 0.0:
            return NodLidarResponse(True, "The lidar does not nod.")
        return NodLidarResponse(
            True, f"The lidar nods by {nod.amplitude_rad:g} rad every {nod.period_s:g} s."
        )

    def _on_swap_battery(self, _request: TriggerRequest) -> TriggerResponse:
        try:
            self._loop.call(self._simulation.swap_battery)
        except SimulationToolsError as error:
            return TriggerResponse(False, str(error))
        return TriggerResponse(True, "A full battery is in.")


def _respond(response_class: Any, action: Callable[[], Answer]) -> Any:
    """Turn an answer into a response. Refuse numbers that are no pose or twist."""
    try:
        answer = action()
    except ValueError as error:
        answer = Answer(False, f"Refused: {error}.")
    return response_class(success=answer.success, status_message=answer.status_message)
