"""What moves: clusters of a scan's points, and their tracks.

A cluster's row is first and end index of its points, middle x and y, radius (m), x and y of the point in its
middle, and how its first and last end are cut off: NOT_CUT, TILTED or HIDDEN. A track's row is x, y (m) of a
disc that holds the thing, velocity (m/s), variance of position, covariance, variance of velocity (per axis),
the disc's radius (m), time unseen, evidence (s), and how far the thing reaches from (x, y) along each of
NORMALS (m, NaN where nobody has seen it).
"""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

FIRST, END, MIDDLE_X, MIDDLE_Y, SIZE, SURFACE_X, SURFACE_Y, CUT_FIRST, CUT_LAST, CLUSTER_COLUMNS = range(10)
NOT_CUT, TILTED, HIDDEN = 0.0, 1.0, 2.0
"""An end is the thing's own, or its beams are far from level, or it is where something hides the rest."""
NORMALS = np.array([(math.cos(k * math.pi / 8), math.sin(k * math.pi / 8)) for k in range(16)])
"""The directions in which a thing's sides are measured."""
X, Y, VX, VY, PP, PV, VV, RADIUS, UNSEEN, EVIDENCE, REACH = range(11)
TRACK_COLUMNS = REACH + len(NORMALS)
ADJACENT_RAD = math.radians(3.0)
RESIZED_M, RESIZED_SHARE = 0.08, 0.1
GRAZING, CUT_M = 0.2, 0.3
"""A side is seen from this sine of the angle of sight on, and so far from an end that is cut off."""
DAMPING, OUTLIER_M = 0.2, 0.1
"""Of the least squares of a thing's sides: so much of one side holds it where it was predicted."""
RESIDUAL_M, SHIFT_M, TURN_RAD = 0.05, 0.05, 0.02
"""Standard deviations: of a standing thing's middle, and of the odometry's error from scan to scan."""


@njit(cache=True)
def laid(
    points: np.ndarray,
    counts: np.ndarray,
    x: float,
    y: float,
    turn: float,
    shift_x: float,
    shift_y: float,
    corrected: np.ndarray,
) -> int:
    """Fill ``corrected`` (n, 2) with the places, m, of ``points`` (n, 2 or 3) that count; return how many.

    counts (n,) bool. The points are relative to the lidar at (x, y) in the odometry's frame. ``turn``, rad,
    about its origin and then the shift, m, correct the odometry's drift.
    """
    c, s, found = math.cos(turn), math.sin(turn), 0
    for k in range(points.shape[0]):
        if counts[k]:
            px, py = points[k, 0] + x, points[k, 1] + y
            corrected[found, 0], corrected[found, 1] = c * px - s * py + shift_x, s * px + c * py + shift_y
            found += 1
    return found


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
    for column, other, at in ((CUT_FIRST, (first - 1) % n, a), (CUT_LAST, end % n, b)):
        cluster[column] = NOT_CUT
        if _hides(points, pose, other, at, gap) or _exceeds(points, pose, bins, at, 0.0):
            cluster[column] = HIDDEN
        elif _exceeds(points, pose, level, at, 1.0):
            cluster[column] = TILTED
    surface = ((first + end - 1) // 2) % n
    cluster[FIRST], cluster[END] = first, end
    cluster[MIDDLE_X], cluster[MIDDLE_Y], cluster[SIZE] = middle_x, middle_y, math.sqrt(largest)
    cluster[SURFACE_X], cluster[SURFACE_Y] = points[surface, 0], points[surface, 1]


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
    Of what moves, a part alone may be in sight, so all of its radius counts.
    """
    for c in range(clusters.shape[0]):
        best = math.inf
        matches[c] = -1
        for t in range(tracks.shape[0]):
            d = _separation(clusters[c], tracks[t])
            share = 1.0 if tracks[t, EVIDENCE] > 0.0 else 0.5
            if d < best and d < gate + 3.0 * math.sqrt(tracks[t, PP]) + share * tracks[t, RADIUS]:
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
def reaches_of(
    points: np.ndarray, cluster: np.ndarray, pose: np.ndarray, cut: float, reaches: np.ndarray
) -> None:
    """Fill ``reaches`` (k,) with how far the thing of a cluster reaches along each of NORMALS, m.

    What stands before the lidar along a normal, sees the lidar, however little of the rest is in sight. Along
    the other normals it may reach farther than its points: NaN. So it is near an end that is ``cut`` or more.
    """
    n, first, end = points.shape[0], int(cluster[FIRST]), int(cluster[END])
    for k in range(NORMALS.shape[0]):
        x, y = NORMALS[k]
        farthest, at = -math.inf, first
        for j in range(first, end):
            reach = x * points[j % n, 0] + y * points[j % n, 1]
            if reach > farthest:
                farthest, at = reach, j % n
        px, py = points[at]
        is_seen = x * pose[0] + y * pose[1] - farthest > GRAZING * math.hypot(px - pose[0], py - pose[1])
        for column, j in ((CUT_FIRST, first % n), (CUT_LAST, (end - 1) % n)):
            if cluster[column] >= cut and math.hypot(px - points[j, 0], py - points[j, 1]) < CUT_M:
                is_seen = False
        reaches[k] = farthest if is_seen else math.nan


@njit(cache=True)
def _shift_of(reaches: np.ndarray, track: np.ndarray, shift: np.ndarray) -> int:
    """Fill ``shift`` (2,) with how far a thing is from its track; return how many known sides tell it.

    Outliers count little. Along an axis that no side tells, it is where it was predicted.
    """
    shift[:] = 0.0
    known = 0
    for _ in range(3):
        a, b, c, right_x, right_y, known = DAMPING, 0.0, DAMPING, 0.0, 0.0, 0
        for k in range(NORMALS.shape[0]):
            x, y = NORMALS[k]
            off = reaches[k] - track[REACH + k] - x * track[X] - y * track[Y]
            if math.isnan(off):
                continue
            w = 1.0 / (1.0 + ((off - x * shift[0] - y * shift[1]) / OUTLIER_M) ** 2)
            a, b, c = a + w * x * x, b + w * x * y, c + w * y * y
            right_x, right_y, known = right_x + w * off * x, right_y + w * off * y, known + 1
        determinant = a * c - b * b
        shift[0] = (c * right_x - b * right_y) / determinant
        shift[1] = (a * right_y - b * right_x) / determinant
    return known


@njit(cache=True)
def align(
    clusters: np.ndarray,
    tracks: np.ndarray,
    owners: np.ndarray,
    moving: np.ndarray,
    points: np.ndarray,
    pose: np.ndarray,
    dt: float,
    least: int,
    motion: np.ndarray,
) -> bool:
    """Fill ``motion`` (3: x, y in m, turn in rad about the lidar) with what lays a scan on standing things.

    They are the tracks that are not ``moving`` (t,) and were seen in the last scan, with known sides and all
    of their clusters in sight. Outliers count little. Returns whether there are at least ``least`` of them.
    With fewer, one that moves could not be told from an error of the odometry. If there are, the points, the
    clusters and the pose are moved by it.
    """
    motion[:] = 0.0
    shifts, reaches = np.full((tracks.shape[0], 2), math.nan), np.empty(NORMALS.shape[0])
    for t in range(tracks.shape[0]):
        if owners[t] < 0 or moving[t] or tracks[t, UNSEEN] > 1.5 * dt:
            continue
        cluster = clusters[owners[t]]
        if max(cluster[CUT_FIRST], cluster[CUT_LAST]) < HIDDEN:
            reaches_of(points, cluster, pose, HIDDEN, reaches)
            if _shift_of(reaches, tracks[t], shifts[t]) == 0:
                shifts[t] = math.nan
    for _ in range(4):
        matrix = np.diag(np.array([1.0 / SHIFT_M**2, 1.0 / SHIFT_M**2, 1.0 / TURN_RAD**2]))
        right = np.zeros(3)
        count = 0
        for t in range(tracks.shape[0]):
            if math.isnan(shifts[t, 0]):
                continue
            count += 1
            cluster = clusters[owners[t]]
            ax, ay = cluster[MIDDLE_X] - pose[0], cluster[MIDDLE_Y] - pose[1]
            rx, ry = -shifts[t, 0] - dt * tracks[t, VX], -shifts[t, 1] - dt * tracks[t, VY]
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
    _lay(clusters, points, pose, motion)
    return True


@njit(cache=True)
def _lay(clusters: np.ndarray, points: np.ndarray, pose: np.ndarray, motion: np.ndarray) -> None:
    """Move a scan by ``motion`` (3,): turn it about the lidar, and shift it."""
    c, s = math.cos(motion[2]), math.sin(motion[2])
    shift_x = pose[0] + motion[0] - c * pose[0] + s * pose[1]
    shift_y = pose[1] + motion[1] - s * pose[0] - c * pose[1]
    for k in range(points.shape[0]):
        x, y = points[k]
        points[k, 0], points[k, 1] = c * x - s * y + shift_x, s * x + c * y + shift_y
    for k in range(clusters.shape[0]):
        for column in (MIDDLE_X, SURFACE_X):
            x, y = clusters[k, column], clusters[k, column + 1]
            clusters[k, column] = c * x - s * y + shift_x
            clusters[k, column + 1] = s * x + c * y + shift_y
    pose += motion


@njit(cache=True)
def correct(
    tracks: np.ndarray,
    clusters: np.ndarray,
    owners: np.ndarray,
    points: np.ndarray,
    pose: np.ndarray,
    deviation: float,
    deviation_hidden: float,
    memory: float,
    learning: float,
) -> None:
    """Take the sides of the clusters as measurements of their tracks; deviations in m.

    The middle of what is in sight jumps when another side comes into sight, or a part goes out of it. A side
    does not. The track learns by the share ``learning`` where its sides are. Before it moves, a thing without
    a known side is measured by its middle. ``memory`` (0 to 1) of the disc's radius is left after each scan,
    and then it grows and shifts so that it holds the cluster. A lidar that leans may see less of a thing
    because its beams pass over the rest. Then a tilted end is cut.
    """
    reaches, shift = np.empty(NORMALS.shape[0]), np.empty(2)
    for t in range(tracks.shape[0]):
        if owners[t] < 0:
            continue
        track, cluster = tracks[t], clusters[owners[t]]
        track[UNSEEN] = 0.0
        is_smaller = cluster[SIZE] < track[RADIUS] - max(RESIZED_M, RESIZED_SHARE * track[RADIUS])
        reaches_of(points, cluster, pose, TILTED if is_smaller else HIDDEN, reaches)
        sigma = deviation
        known = _shift_of(reaches, track, shift)
        if known == 0 and track[EVIDENCE] == 0.0:
            shift[0], shift[1] = cluster[MIDDLE_X] - track[X], cluster[MIDDLE_Y] - track[Y]
            sigma = deviation_hidden
        if known > 0 or track[EVIDENCE] == 0.0:
            gain = 1.0 / (track[PP] + sigma * sigma)
            gain_p, gain_v = track[PP] * gain, track[PV] * gain
            track[X] += gain_p * shift[0]
            track[Y] += gain_p * shift[1]
            track[VX] += gain_v * shift[0]
            track[VY] += gain_v * shift[1]
            track[VV] -= gain_v * track[PV]
            track[PV] *= 1.0 - gain_p
            track[PP] *= 1.0 - gain_p
        for k in range(NORMALS.shape[0]):
            reach = reaches[k] - NORMALS[k, 0] * track[X] - NORMALS[k, 1] * track[Y]
            if math.isnan(track[REACH + k]):
                track[REACH + k] = reach
            elif not math.isnan(reach):
                track[REACH + k] += learning * (reach - track[REACH + k])
        _hold(track, cluster, memory)


@njit(cache=True)
def _hold(track: np.ndarray, cluster: np.ndarray, memory: float) -> None:
    """Shrink a track's disc to ``memory``; then make it the least one that holds it and the cluster."""
    radius, size = memory * track[RADIUS], cluster[SIZE]
    x, y = cluster[MIDDLE_X] - track[X], cluster[MIDDLE_Y] - track[Y]
    apart = math.hypot(x, y)
    track[RADIUS] = max(radius, size, 0.5 * (radius + apart + size))
    if radius < apart + size:
        share = (track[RADIUS] - radius) / apart if size < apart + radius else 1.0
        track[X] += share * x
        track[Y] += share * y
        for k in range(NORMALS.shape[0]):
            track[REACH + k] -= share * (NORMALS[k, 0] * x + NORMALS[k, 1] * y)


@njit(cache=True)
def are_fast(
    tracks: np.ndarray, owners: np.ndarray, speed_min: float, significance: float, fast: np.ndarray
) -> None:
    """Fill ``fast`` (t,) with which tracks are in sight and have a velocity that counts.

    It is above ``speed_min``, m/s, and above so many standard deviations.
    """
    for t in range(tracks.shape[0]):
        least = max(speed_min, significance * math.sqrt(tracks[t, VV]))
        fast[t] = owners[t] >= 0 and math.hypot(tracks[t, VX], tracks[t, VY]) > least


@njit(cache=True)
def weigh(
    tracks: np.ndarray,
    owners: np.ndarray,
    fast: np.ndarray,
    shown: np.ndarray,
    dt: float,
    losses: tuple[float, float],
    enough: float,
    most: float,
    speed_min: float,
    moving: np.ndarray,
) -> None:
    """Update the evidence of the tracks in sight, and which tracks are ``moving`` (t,).

    The evidence grows by ``dt``, s, for a track that has ``shown`` (t,) that it moves, up to ``most``. It
    falls by the first of the losses for one that is ``fast`` (t,), and else by the second. From ``enough`` on
    a track faster than ``speed_min``, m/s, is moving, until there is no evidence any more.
    """
    for t in range(tracks.shape[0]):
        change = 0.0
        if owners[t] >= 0:
            change = 1.0 if shown[t] else -losses[0] if fast[t] else -losses[1]
        evidence = min(max(tracks[t, EVIDENCE] + dt * change, 0.0), most)
        tracks[t, EVIDENCE] = evidence
        starts = evidence > enough and math.hypot(tracks[t, VX], tracks[t, VY]) > speed_min
        moving[t] = starts or (moving[t] and evidence > 0.0)
