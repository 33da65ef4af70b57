"""The safety argument: no disturbance within the response's stated error leads into what stands."""

import math

import numpy as np
import pytest
from planar_flight import BODY_RADIUS_M, Lidar, Scene, to_goal, turn

from cepa import CepaParameters, Dynamic, Motion, Reason
from cepa.dynamic.kernels.admissible import FULL_ERROR_M_S, LEAST_ERROR_SHARE

STEP_S, SCAN_STEPS = 0.005, 10  # 20 scans a second
FLIGHT_S = 6.0
PARAMETERS = CepaParameters()
MODEL = PARAMETERS.response


class DisturbedUav:
    """Follows commands exactly as the model says, but for an acceleration that disturbs it."""

    def __init__(self):
        self.position, self.velocity, self.acceleration = np.zeros(2), np.zeros(2), np.zeros(2)
        self.pending = [(0.0, np.zeros(2))]

    def command(self, t_s, velocity):
        """Fly ``velocity`` (2,), m/s, after the model's delay."""
        self.pending.append((t_s + MODEL.delay_s, np.array(velocity)))

    def step(self, t_s, disturbance):
        """Advance by STEP_S; ``disturbance`` (2,) within the unit disc, as a share of the stated error."""
        while len(self.pending) > 1 and self.pending[1][0] <= t_s:
            self.pending.pop(0)
        command = self.pending[0][1]
        fastest = max(np.hypot(*self.velocity), np.hypot(*command))
        share = max(LEAST_ERROR_SHARE, min(1.0, fastest / FULL_ERROR_M_S))
        change = (MODEL.p * (command - self.velocity) - self.acceleration) / MODEL.lag_s
        change *= min(1.0, MODEL.jerk_max_m_s3 / max(np.hypot(*change), 1e-9))
        self.acceleration = self.acceleration + change * STEP_S
        limit = MODEL.acceleration_max_m_s2 / max(np.hypot(*self.acceleration), 1e-9)
        self.acceleration *= min(1.0, limit)
        self.velocity = (
            self.velocity + (self.acceleration + share * MODEL.error_m_s2 * np.array(disturbance)) * STEP_S
        )
        self.position = self.position + self.velocity * STEP_S


def towards_the_nearest(scene, position):
    """Return the direction (2,) of the nearest trunk."""
    offsets = scene.circles[:, :2] - position
    nearest = np.argmin(np.hypot(*offsets.T) - scene.circles[:, 2])
    return offsets[nearest] / np.hypot(*offsets[nearest])


def least_clearance(scene, speed, disturb, rng, is_watched=lambda t_s: True):
    """Fly through the scene; return the least distance of the UAV's middle from anything, and the reasons."""
    uav, algorithm, lidar = DisturbedUav(), Dynamic(PARAMETERS), Lidar(math.radians(360.0))
    reference = to_goal((40.0, 0.0), speed)
    clearance_m, reasons = math.inf, []
    for step in range(round(FLIGHT_S / STEP_S)):
        t_s = step * STEP_S
        if step % SCAN_STEPS == 0 and is_watched(t_s):
            scan = lidar.scan(scene, uav.position, 0.0, rng)
            pose = (*uav.position, 2.0), (0.0, 0.0, 0.0, 1.0), (*uav.velocity, 0.0)
            decision = algorithm.steer(
                scan, turn(reference(uav.position), 0.0), uav.velocity, Motion(t_s, *pose)
            )
            uav.command(t_s, decision.velocity_xy)
            reasons.append(decision.reason)
            answered_s = t_s
        if t_s - answered_s > algorithm.commit_s:
            uav.command(t_s, (0.0, 0.0))  # as whoever flies the answers must do
        uav.step(t_s, disturb(t_s, scene, uav))
        clearance_m = min(clearance_m, scene.clearance(uav.position))
    return clearance_m, reasons


def thicket(rng):
    """Return trunks of all sizes, none near the start."""
    trunks = np.column_stack(
        (rng.uniform(2.0, 30.0, 70), rng.uniform(-8.0, 8.0, 70), rng.uniform(0.1, 1.0, 70))
    )
    return Scene(circles=trunks[np.hypot(*trunks[:, :2].T) - trunks[:, 2] > 1.5])


def gust(rng):
    """Return a disturbance that changes its direction at random, and is always as strong as it may be."""
    directions = rng.uniform(-math.pi, math.pi, round(FLIGHT_S / 0.2) + 1)
    return lambda t_s, scene, uav: (
        math.cos(directions[int(t_s / 0.2)]),
        math.sin(directions[int(t_s / 0.2)]),
    )


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
@pytest.mark.parametrize("speed", [pytest.param(2.0, marks=pytest.mark.long), 4.0])
def test_no_disturbance_within_the_stated_error_leads_into_a_trunk(speed, seed):
    rng = np.random.default_rng(seed)
    adversary = lambda t_s, scene, uav: towards_the_nearest(scene, uav.position)  # noqa: E731
    for disturb in (adversary, gust(rng)):
        clearance_m, reasons = least_clearance(thicket(rng), speed, disturb, rng)
        assert clearance_m > BODY_RADIUS_M
        assert Reason.STEERED in reasons


@pytest.mark.table("seed", range(2))
def test_without_further_scans_it_brakes_and_touches_nothing(seed):
    rng = np.random.default_rng(100 + seed)
    blind_s = rng.uniform(1.5, 4.0)
    adversary = lambda t_s, scene, uav: towards_the_nearest(scene, uav.position)  # noqa: E731
    in_time = lambda t_s: t_s < blind_s or t_s > blind_s + 2.5  # noqa: E731
    clearance_m, _ = least_clearance(thicket(rng), 4.0, adversary, rng, in_time)
    assert clearance_m > BODY_RADIUS_M


@pytest.mark.table("push", ["none", "towards the wall", "gusts"])
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in (1, 2))])
def test_a_uav_that_never_turns_does_not_creep_back_into_the_unseen(seed, push):
    # A wall 1.3 to 2 m behind, which no beam meets: before it sees, the UAV may go 0.5 m and brake
    rng = np.random.default_rng(seed)
    uav, algorithm, lidar = (
        DisturbedUav(),
        Dynamic(PARAMETERS),
        Lidar(math.radians(rng.uniform(240.0, 270.0))),
    )
    x = -rng.uniform(1.3, 2.0)
    scene, gusts = Scene(walls=np.array([(x, -50.0, x, 50.0)])), gust(rng)
    speed, direction = rng.uniform(0.5, 2.0), math.pi + rng.uniform(-0.15, 0.15)
    v_ref = speed * math.cos(direction), speed * math.sin(direction)
    for step in range(round(FLIGHT_S / STEP_S)):
        t_s = step * STEP_S
        if step % SCAN_STEPS == 0:
            pose = (*uav.position, 2.0), (0.0, 0.0, 0.0, 1.0), (*uav.velocity, 0.0)
            scan = lidar.scan(scene, uav.position, 0.0, rng)
            uav.command(t_s, algorithm.steer(scan, v_ref, uav.velocity, Motion(t_s, *pose)).velocity_xy)
        pushes = {"none": (0.0, 0.0), "towards the wall": (-1.0, 0.0), "gusts": gusts(t_s, scene, uav)}
        uav.step(t_s, pushes[push])
        assert scene.clearance(uav.position) > BODY_RADIUS_M
    assert uav.position[0] < -0.25  # it may set off backwards


@pytest.mark.table(("r_lb", "rear_m"), [(0.8, 0.62), (0.8, 0.53), (0.5, 0.48)])
def test_it_leaves_between_things_within_r_lb_and_touches_nothing(r_lb, rear_m):
    # Columns of 0.2 m around it, those behind nearer, as in Experiment 2; ahead is a gap of 1 m
    bearings, distances = np.radians([52.0, -52.0, 120.0, -120.0]), np.array([0.75, 0.75, rear_m, rear_m])
    columns = np.column_stack((distances * np.cos(bearings), distances * np.sin(bearings), np.full(4, 0.1)))
    scene, uav, lidar = Scene(circles=columns), DisturbedUav(), Lidar(math.radians(360.0))
    algorithm, rng = Dynamic(CepaParameters(r_lb=r_lb)), np.random.default_rng(0)
    assert scene.clearance(uav.position) < r_lb - 0.05
    for step in range(round(5.0 / STEP_S)):
        t_s = step * STEP_S
        if step % SCAN_STEPS == 0:
            pose = (*uav.position, 2.0), (0.0, 0.0, 0.0, 1.0), (*uav.velocity, 0.0)
            scan = lidar.scan(scene, uav.position, 0.0, rng)
            decision = algorithm.steer(scan, (0.0, 0.0), uav.velocity, Motion(t_s, *pose))
            assert step or (decision.emergency and decision.reason is Reason.MARGIN_LOST)
            uav.command(t_s, decision.velocity_xy)
        uav.step(t_s, (0.0, 0.0))
        assert scene.clearance(uav.position) > BODY_RADIUS_M
    assert scene.clearance(uav.position) > r_lb - 0.05
    assert not decision.emergency
