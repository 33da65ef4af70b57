"""Poses and velocities of PyBullet's bodies, for model frames instead of centres of mass."""

from __future__ import annotations

from typing import NamedTuple

from kernel_cache.compiler import njit
from simulation_tools import compiled_geometry
from simulation_tools.geometry import (
    ORIGIN,
    Pose,
    Quaternion,
    Vector3,
    cross,
    quaternion_multiply,
    rotate,
)
from simulation_tools.world.bodies import Body
from simulation_tools.world.engine import pybullet


class BodyState(NamedTuple):
    """Pose and velocity of a model frame; both velocities in world coordinates."""

    pose: Pose
    linear_velocity_m_s: Vector3 = ORIGIN
    angular_velocity_rad_s: Vector3 = ORIGIN


def model_frame(client: int, body: Body) -> Pose:
    """Return the pose of the model frame that a body's base carries."""
    (x, y, z), q = pybullet.getBasePositionAndOrientation(body.uid, physicsClientId=client)
    in_centre = body.from_inertial
    dx, dy, dz = rotate(q, in_centre.position_m)
    return Pose((x + dx, y + dy, z + dz), quaternion_multiply(q, in_centre.orientation_xyzw))


def part_pose(client: int, body: Body, link: int) -> Pose:
    """Return the pose of a part's frame (of a fixed body: of its only shape); link -1: the base."""
    if body.collision is not None:
        return Pose(*pybullet.getBasePositionAndOrientation(body.uid, physicsClientId=client))
    if link < 0:
        return model_frame(client, body)
    state = pybullet.getLinkState(body.uid, link, computeForwardKinematics=1, physicsClientId=client)
    return Pose(state[4], state[5])


def joint_angles_of(client: int, body: Body) -> dict[str, float]:
    """Return the angle of each hinge of a body by its joint's name, rad."""
    return {
        part.joint.name: pybullet.getJointState(body.uid, index, physicsClientId=client)[0]
        for index, part in enumerate(body.parts[1:])
        if part.joint is not None
    }


def state_of(client: int, body: Body) -> BodyState:
    """Return the state of the model frame that a moving body's base carries."""
    centre, q = pybullet.getBasePositionAndOrientation(body.uid, physicsClientId=client)
    velocity, spin = pybullet.getBaseVelocity(body.uid, physicsClientId=client)
    frame, arm = body.from_inertial, body.to_inertial.position_m
    place = _frame_state(centre, q, velocity, spin, frame.position_m, frame.orientation_xyzw, arm)
    return BodyState(Pose(place[0], place[1]), place[2], spin)


@njit(cache=True)
def _frame_state(
    centre: Vector3,
    q: Quaternion,
    velocity: Vector3,
    spin: Vector3,
    at: Vector3,
    turn: Quaternion,
    arm: Vector3,
) -> tuple[Vector3, Quaternion, Vector3]:
    """Return position, orientation and velocity of a frame on a body.

    centre, q, velocity, spin: of the body's inertial frame in the world. at, turn: of the other frame in
    this one. arm: from the other frame to the centre of mass, in the other frame.
    """
    (x, y, z), (dx, dy, dz) = centre, compiled_geometry.rotate(q, at)
    orientation = compiled_geometry.quaternion_multiply(q, turn)
    # PyBullet's velocity is the centre of mass's. The frame's origin also turns about it.
    (vx, vy, vz) = velocity
    (wx, wy, wz) = compiled_geometry.cross(spin, compiled_geometry.rotate(orientation, arm))
    return (x + dx, y + dy, z + dz), orientation, (vx - wx, vy - wy, vz - wz)


def link_state_of(client: int, body: Body, part: int, link_in_part: Pose) -> BodyState:
    """Return the state of a link that belongs to a part of a moving body; part -1: the base."""
    pose = part_pose(client, body, part) @ link_in_part
    if part < 0:
        velocity, spin = pybullet.getBaseVelocity(body.uid, physicsClientId=client)
        centre, _ = pybullet.getBasePositionAndOrientation(body.uid, physicsClientId=client)
    else:
        state = pybullet.getLinkState(
            body.uid, part, computeLinkVelocity=1, computeForwardKinematics=1, physicsClientId=client
        )
        centre, velocity, spin = state[0], state[6], state[7]
    return _carried(pose, centre, velocity, tuple(spin))


def carried_state(carrier: BodyState, place: Pose) -> BodyState:
    """Return the state of a frame at a fixed place in a moving one."""
    return _carried(
        carrier.pose @ place,
        carrier.pose.position_m,
        carrier.linear_velocity_m_s,
        carrier.angular_velocity_rad_s,
    )


def _carried(pose: Pose, centre: Vector3, velocity: Vector3, spin: Vector3) -> BodyState:
    """Return the state of a frame at a pose, of a body whose centre has a velocity and a spin."""
    arm = [there - middle for there, middle in zip(pose.position_m, centre)]
    (vx, vy, vz), (wx, wy, wz) = velocity, cross(spin, arm)
    return BodyState(pose, (vx + wx, vy + wy, vz + wz), spin)


def place(client: int, body: Body, frame: Pose, state: BodyState | None) -> None:
    """Put a body's model frame at a pose. state: the model's new velocities, None if it is fixed."""
    inertial = frame @ body.to_inertial
    pybullet.resetBasePositionAndOrientation(
        body.uid, inertial.position_m, inertial.orientation_xyzw, physicsClientId=client
    )
    if state is None:
        return
    arm = [there - here for there, here in zip(inertial.position_m, state.pose.position_m)]
    wx, wy, wz = cross(state.angular_velocity_rad_s, arm)
    vx, vy, vz = state.linear_velocity_m_s
    pybullet.resetBaseVelocity(
        body.uid, (vx + wx, vy + wy, vz + wz), state.angular_velocity_rad_s, physicsClientId=client
    )
