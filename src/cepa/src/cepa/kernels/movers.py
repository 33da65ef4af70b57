"""What moves: clusters of a scan's points, their tracks, and the evidence that a track is no standing thing.

A cluster's row is first and end index of its points, middle x and y, radius (m), whether something nearer
hides one of its ends, x and y of the point in its middle, and whether the beams at its ends are far from
level. A track's row is x, y (m), velocity (m/s), variance of position, covariance, variance of velocity (per
axis), radius, radius over the last scans (m), time unseen and evidence (s).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

FIRST, END, MIDDLE_X, MIDDLE_Y, SIZE, HIDDEN, SURFACE_X, SURFACE_Y, TILTED, CLUSTER_COLUMNS = range(10)
X, Y, VX, VY, PP, PV, VV, RADIUS, USUAL, UNSEEN, EVIDENCE, TRACK_COLUMNS = range(12)
ADJACENT_RAD = math.radians(3.0)
HEADING_ERROR_RAD = 0.005
RESIZED_M = 0.08
LONG_M = 0.6
RESIDUAL_M, SHIFT_M, TURN_RAD = 0.05, 0.05, 0.02
"""Standard deviations: of a standing thing's middle, and of the odometry's error from scan to scan."""


@njit(cache=True)
def segment(
    points: np.ndarray,
    pose: np.ndarray,
    bins: np.ndarray,
    level: np.ndarray,
    gap: float,
    least_points: int,
    greatest_radius: float,
    clusters: np.ndarray,
    labels: np.ndarray,
) -> int:
    """Part ``points`` (n, 2), in the order of their beams, where two are more than ``gap`` m apart.

    Fills ``clusters`` (c, CLUSTER_COLUMNS) with those that have enough points and are small enough to move,
    and ``labels`` (n,) with each point's cluster or -1; returns their number. pose (3: x, y, turn of the
    bins) and bins (m,) are the scan's, as in ``_is_free``; level (m,): how far its beams are near the lidar's
    height, m. The last and the first point are neighbours. Indices count on beyond n there.
    """
    n = points.shape[0]
    labels[:] = -1
    start = 0
    while start < n and not _apart(points, start - 1, start, gap):
        start += 1
    count, first = 0, start
    for k in range(start + 1, start + n + 1):
        if k < start + n and not _apart(points, k - 1, k % n, gap):
            continue
        if k - first >= least_points and count < clusters.shape[0]:
            cluster = clusters[count]
            _measure(points, pose, bins, level, first, k, gap, cluster)
            if cluster[SIZE] <= greatest_radius:
                for j in range(first, k):
                    labels[j % n] = count
                count += 1
        first = k
    return count


@njit(cache=True)
def _apart(points: np.ndarray, j: int, k: int, gap: float) -> bool:
    dx, dy = points[k, 0] - points[j % points.shape[0], 0], points[k, 1] - points[j % points.shape[0], 1]
    return dx * dx + dy * dy > gap * gap


@njit(cache=True)
def _measure(
    points: np.ndarray,
    pose: np.ndarray,
    bins: np.ndarray,
    level: np.ndarray,
    first: int,
    end: int,
    gap: float,
    cluster: np.ndarray,
) -> None:
    n = points.shape[0]
    a, b = first % n, (end - 1) % n
    middle_x, middle_y = 0.5 * (points[a, 0] + points[b, 0]), 0.5 * (points[a, 1] + points[b, 1])
    largest = 0.0
    for k in range(first, end):
        dx, dy = points[k % n, 0] - middle_x, points[k % n, 1] - middle_y
        largest = max(largest, dx * dx + dy * dy)
    hidden = _hides(points, pose, (first - 1) % n, a, gap) or _hides(points, pose, end % n, b, gap)
    hidden = hidden or _exceeds(points, pose, bins, a, 0.0) or _exceeds(points, pose, bins, b, 0.0)
    tilted = _exceeds(points, pose, level, a, 1.0) or _exceeds(points, pose, level, b, 1.0)
    surface = ((first + end - 1) // 2) % n
    cluster[FIRST], cluster[END] = first, end
    cluster[MIDDLE_X], cluster[MIDDLE_Y], cluster[SIZE] = middle_x, middle_y, math.sqrt(largest)
    cluster[HIDDEN] = 1.0 if hidden else 0.0
    cluster[SURFACE_X], cluster[SURFACE_Y] = points[surface, 0], points[surface, 1]
    cluster[TILTED] = 1.0 if tilted else 0.0


@njit(cache=True)
def _hides(points: np.ndarray, pose: np.ndarray, other: int, end: int, gap: float) -> bool:
    """Whether another cluster's point stands before the end of a cluster, next to it."""
    ox, oy = points[other, 0] - pose[0], points[other, 1] - pose[1]
    ex, ey = points[end, 0] - pose[0], points[end, 1] - pose[1]
    turn = abs(math.atan2(ox * ey - oy * ex, ox * ex + oy * ey))
    return turn < ADJACENT_RAD and math.hypot(ex, ey) - math.hypot(ox, oy) > gap


@njit(cache=True)
def _exceeds(points: np.ndarray, pose: np.ndarray, bins: np.ndarray, end: int, share: float) -> bool:
    """Whether ``share`` of the distance of a cluster's end is more than the bins near it say.

    With share 0: whether it is at the edge of what the lidar sees.
    """
    per_rad = bins.size / (2.0 * math.pi)
    dx, dy = points[end, 0] - pose[0], points[end, 1] - pose[1]
    direction = math.atan2(dy, dx) - pose[2]
    middle = math.floor(direction * per_rad + 0.5)
    least = math.inf
    for b in range(middle - 2, middle + 3):
        least = min(least, bins[b % bins.size])
    return least < share * math.hypot(dx, dy)


@njit(cache=True)
def predict(tracks: np.ndarray, dt: float, acceleration: float) -> None:
    """Move tracks on by ``dt`` s at constant velocity; acceleration: m/s2, its standard deviation for 1 s."""
    q = acceleration * acceleration * dt
    for k in range(tracks.shape[0]):
        track = tracks[k]
        track[X] += dt * track[VX]
        track[Y] += dt * track[VY]
        track[PP] += dt * (2.0 * track[PV] + dt * track[VV]) + q * dt * dt / 3.0
        track[PV] += dt * track[VV] + 0.5 * q * dt
        track[VV] += q
        track[UNSEEN] += dt


@njit(cache=True)
def associate(
    clusters: np.ndarray, tracks: np.ndarray, gate: float, matches: np.ndarray, owners: np.ndarray
) -> None:
    """Fill ``matches`` (c,) with each cluster's track or -1, ``owners`` (t,) with each track's cluster or -1.

    A pair is each other's nearest, within ``gate`` m plus three standard deviations and half the radius.
    """
    for c in range(clusters.shape[0]):
        best = math.inf
        matches[c] = -1
        for t in range(tracks.shape[0]):
            d = _separation(clusters[c], tracks[t])
            if d < best and d < gate + 3.0 * math.sqrt(tracks[t, PP]) + 0.5 * tracks[t, RADIUS]:
                best = d
                matches[c] = t
    for t in range(tracks.shape[0]):
        best = math.inf
        owners[t] = -1
        for c in range(clusters.shape[0]):
            if matches[c] == t:
                d = _separation(clusters[c], tracks[t])
                if d < best:
                    best = d
                    owners[t] = c
    for c in range(clusters.shape[0]):
        if matches[c] >= 0 and owners[matches[c]] != c:
            matches[c] = -1


@njit(cache=True)
def _separation(cluster: np.ndarray, track: np.ndarray) -> float:
    return math.hypot(cluster[MIDDLE_X] - track[X], cluster[MIDDLE_Y] - track[Y])


@njit(cache=True)
def align(
    clusters: np.ndarray,
    tracks: np.ndarray,
    owners: np.ndarray,
    moving: np.ndarray,
    pose: np.ndarray,
    dt: float,
    least: int,
    motion: np.ndarray,
) -> bool:
    """Fill ``motion`` (3: x, y in m, turn in rad about the lidar) with what lays a scan on standing things.

    They are the tracks that are not ``moving`` (t,) and were seen in the last scan, with all of their
    clusters in sight. Outliers count little. Returns whether there are at least ``least`` of them. With
    fewer, one that moves could not be told from an error of the odometry.
    """
    motion[:] = 0.0
    for _ in range(4):
        matrix = np.diag(np.array([1.0 / SHIFT_M**2, 1.0 / SHIFT_M**2, 1.0 / TURN_RAD**2]))
        right = np.zeros(3)
        count = 0
        for t in range(tracks.shape[0]):
            if owners[t] < 0 or moving[t] or tracks[t, UNSEEN] > 1.5 * dt:
                continue
            cluster = clusters[owners[t]]
            if cluster[HIDDEN] > 0.0:
                continue
            count += 1
            ax, ay = cluster[MIDDLE_X] - pose[0], cluster[MIDDLE_Y] - pose[1]
            rx = tracks[t, X] - dt * tracks[t, VX] - cluster[MIDDLE_X]
            ry = tracks[t, Y] - dt * tracks[t, VY] - cluster[MIDDLE_Y]
            ex, ey = rx - motion[0] + motion[2] * ay, ry - motion[1] - motion[2] * ax
            w = 1.0 / (RESIDUAL_M**2 + ex * ex + ey * ey)
            matrix[0, 0] += w
            matrix[1, 1] += w
            matrix[0, 2] -= w * ay
            matrix[1, 2] += w * ax
            matrix[2, 2] += w * (ax * ax + ay * ay)
            right[0] += w * rx
            right[1] += w * ry
            right[2] += w * (ax * ry - ay * rx)
        if count < least:
            motion[:] = 0.0
            return False
        matrix[2, 0], matrix[2, 1] = matrix[0, 2], matrix[1, 2]
        motion[:] = np.linalg.solve(matrix, right)
    return True


@njit(cache=True)
def correct(
    tracks: np.ndarray,
    clusters: np.ndarray,
    owners: np.ndarray,
    deviation: float,
    deviation_hidden: float,
    memory: float,
    learning: float,
) -> None:
    """Take the clusters' middles as measurements of their tracks; deviations in m.

    The radius is the greatest seen, of which ``memory`` (0 to 1) is left after each scan. The usual radius
    follows by the share ``learning``. A middle is as uncertain as the radius differs from the usual one,
    because the thing shows another side. From RESIZED_M and a tenth on the middle jumps, and says nothing of
    the velocity. A lidar that leans may see less of a thing because its beams pass over the rest. Of a lorry
    that passes, a part alone may stay in sight, within the circle of a track that has evidence of moving. In
    both cases the track goes on as predicted.
    """
    for t in range(tracks.shape[0]):
        if owners[t] < 0:
            continue
        track, cluster = tracks[t], clusters[owners[t]]
        track[UNSEEN] = 0.0
        resized = max(RESIZED_M, 0.1 * track[USUAL])
        grown = cluster[SIZE] - track[USUAL]
        within = math.hypot(cluster[MIDDLE_X] - track[X], cluster[MIDDLE_Y] - track[Y]) + cluster[SIZE]
        is_part = cluster[TILTED] > 0.0 or (track[EVIDENCE] > 0.0 and within < track[RADIUS] + resized)
        if is_part and grown < -resized:
            continue
        sigma = math.hypot(deviation_hidden if cluster[HIDDEN] > 0.0 else deviation, grown)
        gain = 1.0 / (track[PP] + sigma * sigma)
        gain_p, gain_v = track[PP] * gain, track[PV] * gain
        dx, dy = cluster[MIDDLE_X] - track[X], cluster[MIDDLE_Y] - track[Y]
        if abs(grown) > resized:
            gain_p, gain_v = 1.0, 0.0
        track[X] += gain_p * dx
        track[Y] += gain_p * dy
        track[VX] += gain_v * dx
        track[VY] += gain_v * dy
        track[VV] -= gain_v * track[PV]
        track[PV] *= 1.0 - gain_p
        track[PP] = (1.0 - gain_p) * track[PP] if gain_p < 1.0 else sigma * sigma
        track[USUAL] += learning * grown
        track[RADIUS] = max(cluster[SIZE], memory * track[RADIUS])


@njit(cache=True)
def _is_free(
    x: float, y: float, from_x: float, from_y: float, turn: float, bins: np.ndarray, gap: float
) -> bool:
    """Whether a scan from (from_x, from_y) sees past (x, y) by more than ``gap`` m.

    bins (m,): how far it sees in equal directions from ``turn`` rad, m, negative where it does not look. All
    directions that pass within half a ``gap`` or HEADING_ERROR_RAD must agree, so the edge of a standing
    thing never counts.
    """
    dx, dy = x - from_x, y - from_y
    distance = math.sqrt(dx * dx + dy * dy)
    if distance < gap:
        return False
    per_rad = bins.size / (2.0 * math.pi)
    middle = math.floor((math.atan2(dy, dx) - turn) * per_rad + 0.5)
    guard = math.ceil((0.5 * gap / distance + HEADING_ERROR_RAD) * per_rad + 0.5)
    least = math.inf
    for b in range(middle - guard, middle + guard + 1):
        least = min(least, bins[b % bins.size])
    return least >= distance + gap


@njit(cache=True)
def are_free(tracks: np.ndarray, pose: np.ndarray, bins: np.ndarray, gap: float, free: np.ndarray) -> None:
    """Fill ``free`` (t,) with whether the scan sees past the place of each track; see ``_is_free``."""
    for t in range(tracks.shape[0]):
        free[t] = _is_free(tracks[t, X], tracks[t, Y], pose[0], pose[1], pose[2], bins, gap)


@njit(cache=True)
def _has_moved(
    points: np.ndarray,
    cluster: np.ndarray,
    surfaces: np.ndarray,
    pose: np.ndarray,
    bins: np.ndarray,
    frames: np.ndarray,
    frames_bins: np.ndarray,
    ages: np.ndarray,
    youngest: float,
    gap: float,
    share: float,
    samples: int,
) -> bool:
    """Whether a track's cluster is where earlier scans saw nothing, or is gone from where it was.

    surfaces (f, 2): the middle of its points in earlier scans, NaN where it was not seen. frames (f, 3: x, y,
    turn of the bins), frames_bins (f, m), ages (f,): those scans; younger than ``youngest`` s they do not
    count. pose (3,), bins (m,): the scan's own. ``share`` of ``samples`` points must be in the free, each in
    two earlier scans.
    """
    vacated = 0
    for f in range(ages.size):
        if ages[f] < youngest or math.isnan(surfaces[f, 0]):
            continue
        if _is_free(surfaces[f, 0], surfaces[f, 1], pose[0], pose[1], pose[2], bins, gap):
            vacated += 1
    if vacated >= 2:
        return True
    n = points.shape[0]
    first, size = int(cluster[FIRST]), int(cluster[END] - cluster[FIRST])
    taken = min(samples, size)
    entered = 0
    for s in range(taken):
        k = (first + (s * size + size // 2) // taken) % n
        times = 0
        for f in range(ages.size):
            if ages[f] >= youngest:
                x, y, turn = frames[f, 0], frames[f, 1], frames[f, 2]
                if _is_free(points[k, 0], points[k, 1], x, y, turn, frames_bins[f], gap):
                    times += 1
                    if times == 2:
                        entered += 1
                        break
    return entered >= max(2.0, share * taken)


@njit(cache=True)
def weigh(
    tracks: np.ndarray,
    clusters: np.ndarray,
    owners: np.ndarray,
    surfaces: np.ndarray,
    points: np.ndarray,
    pose: np.ndarray,
    bins: np.ndarray,
    frames: np.ndarray,
    frames_bins: np.ndarray,
    ages: np.ndarray,
    youngest: float,
    gap: float,
    share: float,
    samples: int,
    dt: float,
    speed_min: float,
    significance: float,
    greatest: float,
) -> None:
    """Add ``dt`` s to the evidence of each seen track that is significantly fast and has moved.

    It takes half of that from the other seen tracks. The evidence stays within 0 and ``greatest`` s.
    surfaces (t, f, 2); the other arguments as in ``_has_moved``.
    """
    for t in range(tracks.shape[0]):
        if owners[t] < 0:
            continue
        track = tracks[t]
        speed = math.hypot(track[VX], track[VY])
        shown = speed > speed_min and speed > significance * math.sqrt(track[VV])
        if shown:
            cluster = clusters[owners[t]]
            scans = pose, bins, frames, frames_bins, ages
            larger = max(1.0, cluster[SIZE] / LONG_M)  # only an end of a long thing enters what was free
            looks = math.ceil(larger * samples)
            shown = _has_moved(points, cluster, surfaces[t], *scans, youngest, gap, share / larger, looks)
        track[EVIDENCE] = min(greatest, max(0.0, track[EVIDENCE] + (dt if shown else -0.5 * dt)))
