"""Where an actor's script puts it, and how fast it moves there.

Positions follow the spline of Gazebo's `PoseAnimation`: on each piece between two waypoints a cubic Hermite
curve, whose tangent at a waypoint is half the way from the waypoint before to the one after, times
1 - tension; at the ends half of the only piece there is, or as at a waypoint between if the trajectory ends
where it begins. Orientations turn evenly from one waypoint to the next.
"""

from __future__ import annotations

from bisect import bisect_right

from simulation_tools.geometry import (
    Pose,
    Vector3,
    quaternion_conjugate,
    quaternion_from_rotation_vector,
    quaternion_multiply,
    rotation_vector_from_quaternion,
)
from simulation_tools.sdf.elements import Script, Trajectory, Waypoint
from simulation_tools.world.kinematics import BodyState


class ScriptedMotion:
    """Evaluates a script. Before the script's first delay is over, the actor is where its model stands."""

    def __init__(self, script: Script) -> None:
        self._script = script
        self._pieces = [_Spline(trajectory) for trajectory in script.trajectories]
        self._length_s = sum(trajectory.duration_s for trajectory in script.trajectories)

    def state(self, time_s: float) -> BodyState | None:
        """Return the state so long after the script's start; None while the script does not move it."""
        script = self._script
        if not script.starts or time_s < script.delay_s:
            return None
        into_s = time_s - script.delay_s
        if into_s >= self._length_s:
            into_s = into_s % (self._length_s + script.delay_s) if script.loop else self._length_s
            if into_s >= self._length_s:  # over, or waiting for the next round
                return BodyState(self._pieces[-1].last.pose)
        piece = self._pieces[0]
        for following in self._pieces[1:]:
            if into_s <= piece.last.time_s:
                break
            into_s -= piece.last.time_s
            piece = following
        return piece.state(into_s)


class _Spline:
    """One trajectory. last: its last waypoint."""

    def __init__(self, trajectory: Trajectory) -> None:
        waypoints = list(trajectory.waypoints)
        if waypoints[0].time_s > 0.0:  # it waits at the first one until its time
            waypoints.insert(0, Waypoint(0.0, waypoints[0].pose))
        self.last = waypoints[-1]
        self._waypoints = waypoints
        self._times_s = [waypoint.time_s for waypoint in waypoints]
        self._tangents = _tangents([w.pose.position_m for w in waypoints], 1.0 - trajectory.tension)
        self._turns = [
            rotation_vector_from_quaternion(
                quaternion_multiply(
                    after.pose.orientation_xyzw, quaternion_conjugate(before.pose.orientation_xyzw)
                )
            )
            for before, after in zip(waypoints, waypoints[1:])
        ]

    def state(self, time_s: float) -> BodyState:
        """Return the state at a time of the trajectory, from 0 to its last waypoint's."""
        k = min(bisect_right(self._times_s, time_s), len(self._times_s) - 1) - 1
        before, after = self._waypoints[k].pose, self._waypoints[k + 1].pose
        duration_s = self._times_s[k + 1] - self._times_s[k]
        u = (time_s - self._times_s[k]) / duration_s
        # Hermite's basis: weights of both ends and both tangents, and their derivatives by u
        end, first, second = u * u * (3.0 - 2.0 * u), u * (1.0 - u) ** 2, u * u * (u - 1.0)
        end_d, first_d, second_d = 6.0 * u * (1.0 - u), (1.0 - u) * (1.0 - 3.0 * u), u * (3.0 * u - 2.0)
        axes = list(zip(before.position_m, after.position_m, self._tangents[k], self._tangents[k + 1]))
        x, y, z = (a + end * (b - a) + first * ta + second * tb for a, b, ta, tb in axes)
        vx, vy, vz = ((end_d * (b - a) + first_d * ta + second_d * tb) / duration_s for a, b, ta, tb in axes)
        wx, wy, wz = self._turns[k]
        turned = quaternion_from_rotation_vector((u * wx, u * wy, u * wz))
        return BodyState(
            Pose((x, y, z), quaternion_multiply(turned, before.orientation_xyzw)),
            (vx, vy, vz),
            (wx / duration_s, wy / duration_s, wz / duration_s),
        )


def _tangents(points: list[Vector3], slack: float) -> list[Vector3]:
    closed = points[0] == points[-1]
    before = [points[-2] if closed else points[0], *points[:-1]]
    after = [*points[1:], points[1] if closed else points[-1]]
    half = 0.5 * slack
    return [
        (half * (there[0] - here[0]), half * (there[1] - here[1]), half * (there[2] - here[2]))
        for here, there in zip(before, after)
    ]
