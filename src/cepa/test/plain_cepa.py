"""Slow and literal versions of what the compiled code does."""

from __future__ import annotations

import math

import numpy as np

from cepa.algorithm import REFERENCE_INCREMENT_RAD, normal_form
from cepa.decision import Vector2
from cepa.parameters import CepaParameters
from cepa.scan import Beams, LaserScan2D
from cepa.thesis.cushion import emergency_edge, improved_cushion, original_cushion, stopping_distance
from cepa.thesis.kernels.emergency import ALONGSIDE_M


def improved_costs(
    parameters: CepaParameters, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2 = (0.0, 0.0)
):
    """Return (velocities (M, 2), costs (M,)) of every candidate with the improved cushion and k1 (6.2.1)."""
    k1 = math.hypot(*v_uav) * parameters.k4 + parameters.k5
    return _costs(parameters, scan, v_ref, k1, improved_cushion)


def cost_of_leaving(
    parameters: CepaParameters, velocities: np.ndarray, v_ref: Vector2, previous: Vector2
) -> np.ndarray:
    """Return what velocities (M, 2) cost more, because they leave the direction of the previous answer."""
    speeds = np.hypot(velocities[:, 0], velocities[:, 1])
    off_rad = np.arctan2(velocities[:, 1], velocities[:, 0]) - math.atan2(previous[1], previous[0])
    return parameters.k_previous * math.hypot(*v_ref) * speeds * (1.0 - np.cos(off_rad))


def original_costs(parameters: CepaParameters, scan: LaserScan2D, v_ref: Vector2):
    """Return (velocities (M, 2), costs (M,)) of every candidate with the original cushion and k1 (6.2)."""
    return _costs(parameters, scan, v_ref, parameters.k1, original_cushion)


def cost(parameters: CepaParameters, beams: Beams, v: Vector2, v_ref: Vector2, k1: float, cushion) -> float:
    """Return equation 6.5 for the velocity ``v`` (m/s, scan's frame); inf when an obstacle forbids it."""
    angle = np.array([math.atan2(v[1], v[0])])
    return float(_costs_at_speed(parameters, beams, math.hypot(*v), angle, v_ref, k1, cushion)[0])


def k_filter(beams: Beams, slope: float) -> np.ndarray:
    """Return LS' (N,): min over j of (LS_j + slope * angle(i, j)), by trying every pair."""
    directions = beams.angles
    between = np.abs(wrap(directions[:, None] - directions[None, :]))
    return np.min(beams.ranges[None, :] + slope * between, axis=1)


def emergency_edges(parameters: CepaParameters, beams: Beams, v_uav: Vector2) -> np.ndarray:
    """Return the range (N,) in m of each beam within which an obstacle is an emergency."""
    speed = math.hypot(*v_uav) if parameters.velocity_aware_emergency else 0.0
    stopping = stopping_distance(speed, parameters.braking_deceleration, parameters.braking_latency)
    psi = wrap(beams.angles - math.atan2(v_uav[1], v_uav[0]))
    return emergency_edge(psi, stopping, parameters.r_lb, parameters.body_radius)


def is_safe(parameters: CepaParameters, beams: Beams, angle: float) -> bool:
    """Tell whether nothing seen is within body_radius of the first emergency_lookahead metres of a direction.

    What already is within body_radius of the UAV itself forbids only the directions that lead towards it.
    """
    psi = beams.angles - angle
    hits = np.isfinite(beams.ranges)
    ahead = beams.ranges[hits] * np.cos(psi[hits])
    aside = beams.ranges[hits] * np.sin(psi[hits])
    beyond = np.clip(ahead - parameters.emergency_lookahead, 0.0, None)
    within = (np.hypot(beyond, aside) <= parameters.body_radius) | (
        beams.ranges[hits] <= parameters.body_radius
    )
    return not np.any((ahead > ALONGSIDE_M) & within)


def wrap(angle: np.ndarray) -> np.ndarray:
    """Wrap to (-pi, pi]."""
    return -((-angle + math.pi) % (2.0 * math.pi) - math.pi)


def _costs(parameters, scan, v_ref, k1, cushion) -> tuple[np.ndarray, np.ndarray]:
    """Cost v_ref and every eligible beam's direction times every speed fraction."""
    beams = normal_form(scan, parameters)
    eligible = beams.seen | parameters.unseen_is_free
    directions = beams.angles
    towards = math.atan2(v_ref[1], v_ref[0])
    own_beam = np.argmin(np.abs(wrap(directions - towards)))
    groups = [(math.hypot(*v_ref), np.array([towards]) if eligible[own_beam] else np.empty(0))]
    groups += [
        (fraction * math.hypot(*v_ref), directions[eligible]) for fraction in parameters.speed_fractions
    ]
    velocities = [speed * np.stack([np.cos(angle), np.sin(angle)], axis=1) for speed, angle in groups]
    costs = [_costs_at_speed(parameters, beams, *group, v_ref, k1, cushion) for group in groups]
    return np.concatenate(velocities), np.concatenate(costs)


def _costs_at_speed(parameters, beams, speed, towards, v_ref, k1, cushion) -> np.ndarray:
    """Return equation 6.5 for each direction ``towards`` (M,), rad, at one speed."""
    psi = wrap(beams.angles[None, :] - towards[:, None])
    edge_lb = cushion(psi, speed, parameters.r_lb, parameters.time_horizon)
    edge_ub = cushion(psi, speed, parameters.r_ub, parameters.time_horizon)
    depth = np.clip(edge_ub - beams.ranges, 0.0, None)
    omega = np.sum(depth**2, axis=1) * beams.increment / REFERENCE_INCREMENT_RAD
    omega[np.any(beams.ranges <= edge_lb, axis=1)] = np.inf
    along = speed * (np.cos(towards) * v_ref[0] + np.sin(towards) * v_ref[1])
    travel = k1 * along + parameters.k2 * speed / math.hypot(*v_ref)
    return np.where(np.isinf(omega), np.inf, parameters.k3 * np.where(np.isinf(omega), 0.0, omega) - travel)
