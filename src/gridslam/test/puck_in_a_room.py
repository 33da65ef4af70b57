"""A lidar of 16 rings in a bare room with a step in a wall, in closed form, and a UAV that flies there."""

import math

import numpy as np

from gridslam.odometry.inertial import GRAVITY_MPS2, InertialReading

SIZE = np.array([9.0, 7.0, 5.0])
"""The room reaches from the origin to here; z is up, the floor is z = 0."""
BLOCK = np.array([[6.0, 0.0, 0.0], [9.0, 2.0, 5.0]])
"""A corner of the room that is filled."""
ELEVATIONS = np.radians(np.linspace(-15.0, 15.0, 16))
DOWN = ((0.0, 0.0, 0.0), (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5)))
LEVEL = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
LIMITS_M = (0.05, 20.0)


def directions(beams=360):
    azimuths = np.linspace(-np.pi, np.pi, beams, endpoint=False)
    elevation, azimuth = (each.ravel() for each in np.meshgrid(ELEVATIONS, azimuths, indexing="ij"))
    level = np.cos(elevation)
    return np.column_stack((level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)))


def ranges_m(origin, rays):
    """Distances to the room's faces from inside, and to the block's from outside: slabs."""
    with np.errstate(divide="ignore", invalid="ignore"):
        to_walls = np.where(rays > 0, (SIZE - origin) / rays, -origin / rays)
        found = np.where(rays == 0, np.inf, to_walls).min(axis=1)
        ends = np.sort((BLOCK[:, None, :] - origin) / rays, axis=0)
        enters, leaves = np.nanmax(ends[0], axis=1), np.nanmin(ends[1], axis=1)
    hits = (enters < leaves) & (enters > 0)
    return np.where(hits, np.minimum(found, enters), found)


def cloud(place, rotation, rng, noise_m=0.01, seen_m=ranges_m):
    rays = directions()
    far_m = seen_m(np.asarray(place), rays @ rotation.T) + rng.normal(0.0, noise_m, len(rays))
    return rays * far_m[:, None]


def heading(yaw_rad):
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    return np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))


def place_at(time_s):
    """A loop at up to 1 m/s that climbs from 0.6 to 4 m and comes back, after a second at rest."""
    turn = 2.0 * math.pi * max(time_s - 1.0, 0.0) / 30.0
    turn -= math.sin(turn) if turn < 2.0 * math.pi else 2.0 * math.pi  # begins and ends at rest
    return np.array(
        [3.0 + 2.0 * (1 - math.cos(turn)) / 2, 3.5 + 1.8 * math.sin(turn), 2.3 - 1.7 * math.cos(turn)]
    )


def yaw_at(time_s):
    return 0.4 * math.sin(0.3 * time_s)


def fly(
    odometry,
    until_s,
    rng,
    has_range=True,
    at=place_at,
    rate_hz=10,
    pitch_told=lambda time_s: 0.0,
    seen_m=ranges_m,
):
    """Feed the odometry and return (time in s, estimate, true place) of each cloud, the IMU at 50 Hz.

    pitch_told: what the IMU says, rad; the UAV is always level. seen_m: distances from a place along rays.
    """
    flown, step_s = [], 0.02
    for tick in range(int(until_s / step_s) + 1):
        time_s = tick * step_s
        rotation = heading(yaw_at(time_s))
        push = (at(time_s + step_s) - 2 * at(time_s) + at(max(time_s - step_s, 0.0))) / step_s**2
        rate = (yaw_at(time_s + step_s) - yaw_at(time_s)) / step_s
        force = rotation.T @ (push + np.array([0.0, 0.0, GRAVITY_MPS2]))
        half = 0.5 * pitch_told(time_s)
        lean = (0.0, math.sin(half), 0.0, math.cos(half))
        odometry.on_imu(InertialReading(time_s, lean, (0.0, 0.0, rate), tuple(force)))
        if tick % (50 // rate_hz):
            continue
        place = at(time_s)
        if has_range:
            below_m = float(seen_m(place, np.array([[0.0, 0.0, -1.0]]))[0])
            odometry.on_range(time_s, below_m + rng.normal(0.0, 0.01), LIMITS_M, DOWN)
        estimate = odometry.on_cloud(time_s, cloud(place, rotation, rng, seen_m=seen_m), LEVEL)
        flown.append((time_s, estimate, place))
    return flown


def errors(flown):
    """Errors (n, 3) of the place, from the start on."""
    estimates = np.array([estimate.position_xyz for _, estimate, _ in flown])
    true = np.array([place for _, _, place in flown])
    return estimates - true
