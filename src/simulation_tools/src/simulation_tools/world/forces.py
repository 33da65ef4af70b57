"""Forces on PyBullet's bodies during the next step."""

from __future__ import annotations

from typing import Sequence

from simulation_tools.geometry import ORIGIN, Pose, Vector3, rotate_inverse
from simulation_tools.world.assembly import MassProperties
from simulation_tools.world.bodies import Body
from simulation_tools.world.engine import pybullet
from simulation_tools.world.kinematics import part_pose


def push(client: int, body: Body, force_n: Sequence[float], torque_nm: Sequence[float]) -> None:
    """Push and turn a body's base at its centre of mass. Force and torque are in the model frame's axes."""
    turn = body.to_inertial.orientation_xyzw
    if turn[3] != 1.0:
        force_n, torque_nm = rotate_inverse(turn, force_n), rotate_inverse(turn, torque_nm)
    # PyBullet's LINK_FRAME is the inertial frame, for force and place alike.
    frame = pybullet.LINK_FRAME
    pybullet.applyExternalForce(body.uid, -1, force_n, ORIGIN, frame, physicsClientId=client)
    pybullet.applyExternalTorque(body.uid, -1, torque_nm, frame, physicsClientId=client)


def hold_up(client: int, body: Body, link: int, weightless: MassProperties, gravity_m_s2: Vector3) -> None:
    """Cancel the gravity on a part without weight, because PyBullet's gravity acts on every body."""
    force = [-weightless.mass_kg * pull for pull in gravity_m_s2]
    centre = part_pose(client, body, link) @ Pose(tuple(weightless.centre_m.tolist()))
    pybullet.applyExternalForce(
        body.uid, link, force, centre.position_m, pybullet.WORLD_FRAME, physicsClientId=client
    )
