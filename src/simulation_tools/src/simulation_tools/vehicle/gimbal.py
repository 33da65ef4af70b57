"""A gimbal that keeps a lidar level while the UAV leans (thesis, 9.2.4), or lets it nod about level.

Two hinges, roll outside and pitch inside, as the SDF model describes them. The gimbal measures its own
attitude, and its motors are much faster than the airframe. So it is exact within its limits and its rate.
The physics ignores its motion: there the hinges always stay at zero.
"""

from __future__ import annotations

import math

import numpy as np

from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Pose, Quaternion, Vector3, rotate, rotate_inverse
from simulation_tools.sdf.elements import Joint, Model, Plugin
from simulation_tools.sdf.frames import joint_rotation
from simulation_tools.vehicle.nod import Nod

GIMBAL = "libsimulation_tools_gimbal.so"
DEFAULT_RATE_RAD_S = 10.0
AXIS_TOLERANCE = 1e-6


class GimbalError(SimulationToolsError):
    """A model describes a gimbal that cannot be, or a gimbal is asked for what it cannot do."""


class Gimbal:
    """The gimbal of one model. level: whether it levels; if not, its hinges go back to zero.

    nod: the sweep about level, or None. used: whether it has moved before. carries: names of the links that
    turn with it. angles_rad: of roll and pitch.
    """

    def __init__(self, model: Model, roll: Joint, pitch: Joint, max_rate_rad_s: float) -> None:
        """Place it. roll, pitch: revolute joints about the model's x and y axes, pitch carried by roll."""
        self.joint_names = (roll.name, pitch.name)
        self.carries = _carried(model, pitch)
        self.level = self.used = False
        self.nod: Nod | None = None
        self._nodded_s = 0.0
        self.angles_rad = (0.0, 0.0)
        self._joints = (roll, pitch)
        self._places = tuple(model.link(joint.child).pose for joint in self._joints)
        self._max_rate_rad_s = max_rate_rad_s
        self._turn = Pose()

    @classmethod
    def from_sdf(cls, model: Model) -> Gimbal | None:
        """Read the gimbal from the model's plugin; None when there is none. Raises GimbalError."""
        plugins = [plugin for plugin in model.plugins if plugin.filename == GIMBAL]
        if len(plugins) > 1:
            raise GimbalError(f"{model.source}:{plugins[1].line}: A model can have one gimbal only.")
        return _read(model, plugins[0]) if plugins else None

    @property
    def is_active(self) -> bool:
        """Whether it levels or nods, or still turns back to zero."""
        return self.level or self.nod is not None or self.angles_rad != (0.0, 0.0)

    def switch(self, level: bool) -> None:
        """Level from now on, or go back to zero."""
        self.level = level
        self.used = self.used or level

    def start_nod(self, nod: Nod) -> None:
        """Nod from the next step on, beginning level and downwards. An amplitude of 0 ends the nodding.

        Raises:
            GimbalError: the hinges cannot turn so far or so fast.
        """
        self._check_reach(nod)
        self.nod, self._nodded_s = (nod, 0.0) if nod.amplitude_rad > 0.0 else (None, 0.0)
        self.used = True

    def _check_reach(self, nod: Nod) -> None:
        asked = f"A nod by {nod.amplitude_rad:g} rad"
        reach_rad = min(min(joint.upper_rad, -joint.lower_rad) for joint in self._joints)
        if nod.amplitude_rad > reach_rad:
            raise GimbalError(f"{asked} is too wide: the gimbal turns by {reach_rad:g} rad at most.")
        if nod.greatest_rate_rad_s > self._max_rate_rad_s:
            raise GimbalError(
                f"{asked} every {nod.period_s:g} s needs {nod.greatest_rate_rad_s:.1f} rad/s, and the gimbal "
                f"turns at {self._max_rate_rad_s:g} rad/s; give a longer period."
            )

    def step(self, orientation_xyzw: Quaternion, dt_s: float) -> None:
        """Turn the hinges for dt_s. orientation: of the model in the world."""
        wanted = self._wanted(orientation_xyzw, dt_s)
        reach = self._max_rate_rad_s * dt_s
        roll, pitch = (
            now + min(max(min(max(to, joint.lower_rad), joint.upper_rad) - now, -reach), reach)
            for to, now, joint in zip(wanted, self.angles_rad, self._joints)
        )
        self.angles_rad = (roll, pitch)
        self._turn = Pose()
        for place, joint, angle in zip(self._places, self._joints, self.angles_rad):
            self._turn = self._turn @ place @ joint_rotation(joint, angle) @ place.inverse()

    def _wanted(self, orientation_xyzw: Quaternion, dt_s: float) -> tuple[float, float]:
        self._nodded_s += dt_s
        if self.nod is not None and self.nod.is_over(self._nodded_s):
            self.nod = None
        if not self.level and self.nod is None:
            return (0.0, 0.0)
        roll, pitch = level_angles(orientation_xyzw)
        swept = self.nod.angles_at(self._nodded_s) if self.nod else (0.0, 0.0)
        return roll + swept[0], pitch + swept[1]

    def turned(self, pose: Pose) -> Pose:
        """Return the present pose of what it carries, from its pose with the hinges at zero (model frame)."""
        return self._turn @ pose if self.angles_rad != (0.0, 0.0) else pose

    def reset(self, level: bool) -> None:
        """Start again with the hinges at zero. A nod ends."""
        self.switch(level)
        self.nod = None
        self.angles_rad = (0.0, 0.0)


def level_angles(orientation_xyzw: Quaternion) -> tuple[float, float]:
    """Return roll and pitch of the hinges that make R Rx(roll) Ry(pitch) z point straight up, radians.

    With u = R^T z, the upward direction in the model frame,
    Rx(a) Ry(b) z = (sin b, -sin a cos b, cos a cos b) must equal u.
    """
    x, y, z = rotate_inverse(orientation_xyzw, (0.0, 0.0, 1.0))
    return math.atan2(-y, z), math.asin(min(max(x, -1.0), 1.0))


def _read(model: Model, plugin: Plugin) -> Gimbal:
    where = f"{model.source or model.name}:{plugin.line}: The gimbal's plugin"
    joints = []
    for key, axis in (("rollJoint", (1.0, 0.0, 0.0)), ("pitchJoint", (0.0, 1.0, 0.0))):
        name = plugin.parameters.get(key, "")
        try:
            joint = model.joint(name)
        except KeyError:
            raise GimbalError(f'{where} names the {key} "{name}", which does not exist.') from None
        if joint.kind != "revolute" or not np.allclose(_axis(model, joint), axis, atol=AXIS_TOLERANCE):
            raise GimbalError(f"{where} needs a {key} that turns about the axis {axis} of the model.")
        joints.append(joint)
    roll, pitch = joints
    if pitch.child not in _carried(model, roll):
        raise GimbalError(f"{where} needs a pitch joint that the roll joint carries.")
    try:
        rate = float(plugin.parameters.get("maxRate", DEFAULT_RATE_RAD_S))
    except ValueError:
        rate = math.nan
    if not 0.0 < rate < math.inf:
        raise GimbalError(f"{where} needs a positive <maxRate>, in rad/s.")
    return Gimbal(model, roll, pitch, rate)


def _axis(model: Model, joint: Joint) -> Vector3:
    """Axis of a joint in the model frame."""
    return rotate((model.link(joint.child).pose @ joint.pose).orientation_xyzw, joint.axis)


def _carried(model: Model, joint: Joint) -> frozenset[str]:
    """Names of the links that a joint carries, directly or through others."""
    found = {joint.child}
    while True:
        more = {other.child for other in model.joints if other.parent in found} - found
        if not more:
            return frozenset(found)
        found |= more
