"""What a photograph shows: pinhole geometry, and pairs that may see each other."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

Triple = tuple[float, float, float]
Eye = tuple[Triple, tuple[Triple, Triple, Triple], tuple[float, float, float, float]]
"""Place of a camera, its optical axes and lens, as numbers: with arrays loops take thrice as long."""


@njit(cache=True, nogil=True)
def worst_scale(x: float, y: float, z: float, normal: np.ndarray | Triple, blur: float) -> float:
    """Return how much surface a pixel covers in the worst direction, in m, times the focal length in px.

    A step (du, dv) in the picture at depth 1 moves the point on the surface by z times a du + b dv, where a
    and b are the picture's axes, slid along the line of sight into the surface. The greatest singular value
    of (a, b) is the worst direction. It holds foreshortening and the place in the picture. A motion of the
    camera during the exposure moves the point likewise, in the worst direction by this value times the
    motion; both widths are added in quadrature, as the spreads of two blurs one after the other.

    Args:
        x: tangent of the line of sight from the optical axis, to the right.
        y: likewise, down.
        z: depth, m.
        normal: (3,) of the surface, in the optical frame.
        blur: motion during the exposure, in m, times the focal length in px.
    """
    along = normal[0] * x + normal[1] * y + normal[2]
    p, q = normal[0] / along, normal[1] / along
    ax, ay, az = 1.0 - x * p, -y * p, -p
    bx, by, bz = -x * q, 1.0 - y * q, -q
    aa, bb, ab = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz, ax * bx + ay * by + az * bz
    return math.sqrt(z * z + blur * blur) * math.sqrt(
        0.5 * (aa + bb + math.sqrt((aa - bb) ** 2 + 4.0 * ab * ab))
    )


@njit(cache=True, nogil=True)
def eye_of(place: np.ndarray, axes: np.ndarray, lens: np.ndarray) -> Eye:
    """Return the numbers of a camera for `is_drawn`.

    Args:
        place: (3,) of the camera.
        axes: (3, 3), the optical frame's axes in its columns.
        lens: (4,) tangents to the right and the lower edge; the greatest `worst_scale`; and its `blur`.
    """
    return (
        triple(place),
        (triple(axes[:, 0]), triple(axes[:, 1]), triple(axes[:, 2])),
        (lens[0], lens[1], lens[2], lens[3]),
    )


@njit(cache=True, nogil=True)
def triple(values: np.ndarray) -> Triple:
    """Return (3,) values as numbers."""
    return values[0], values[1], values[2]


@njit(cache=True, nogil=True)
def is_drawn(eye: Eye, point: Triple, normal: Triple) -> bool:
    """Return whether a photograph draws a point finely enough, if nothing is between.

    eye: of the camera. point: on the surface. normal: of the surface there.
    """
    place, (right, down, ahead), (width, height, most, blur) = eye
    way = (point[0] - place[0], point[1] - place[1], point[2] - place[2])
    z = dot(ahead, way)
    if z <= 1e-6:
        return False
    x, y = dot(right, way), dot(down, way)
    if abs(x) > width * z or abs(y) > height * z:
        return False
    turned = (dot(right, normal), dot(down, normal), dot(ahead, normal))
    return worst_scale(x / z, y / z, z, turned, blur) <= most


@njit(cache=True, nogil=True)
def dot(a: Triple, b: Triple) -> float:
    """Return the inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True)
def axes_of(yaw: float, tilt: float) -> np.ndarray:
    """Return (3, 3) as `survey.camera.optical_axes`."""
    sy, cy, st, ct = math.sin(yaw), math.cos(yaw), math.sin(tilt), math.cos(tilt)
    axes = np.empty((3, 3))
    axes[0, 0], axes[1, 0], axes[2, 0] = sy, -cy, 0.0
    axes[0, 1], axes[1, 1], axes[2, 1] = cy * st, sy * st, -ct
    axes[0, 2], axes[1, 2], axes[2, 2] = cy * ct, sy * ct, st
    return axes


@njit(cache=True, nogil=True)
def pairs_near(
    places: np.ndarray, points: np.ndarray, normals: np.ndarray, far: float, least_cosine: float, scale: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs of places and points that may see each other: begins (n + 1,) and points (k,).

    A point is within `far`, is met at an angle with at least this cosine, and no farther than `scale` times
    the cosine. The points of place i are those from begins[i] to before begins[i + 1].
    """
    begins = np.zeros(len(places) + 1, np.int64)
    found = np.empty(max(1024, 64 * len(places)), np.int32)
    count = 0
    for n in range(len(places)):
        px, py, pz = places[n, 0], places[n, 1], places[n, 2]
        if count + len(points) > len(found):
            found = np.concatenate((found, np.empty(len(found) + len(points), np.int32)))
        for m in range(len(points)):
            dx = px - points[m, 0]
            if dx > far or dx < -far:
                continue
            dy = py - points[m, 1]
            if dy > far or dy < -far:
                continue
            dz = pz - points[m, 2]
            apart = math.sqrt(dx * dx + dy * dy + dz * dz)
            if apart > far or apart < 1e-6:
                continue
            cosine = (dx * normals[m, 0] + dy * normals[m, 1] + dz * normals[m, 2]) / apart
            if cosine >= least_cosine and apart <= scale * cosine:
                found[count] = m
                count += 1
        begins[n + 1] = count
    return begins, found[:count].copy()


@njit(cache=True, nogil=True)
def drawn_straight(
    places: np.ndarray, begins: np.ndarray, seen: np.ndarray, points: np.ndarray, normals: np.ndarray,
    lens: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Return (k,) whether photographs draw the points that their places see, if they look straight at them.

    begins, seen: pairs as of `pairs_near`. lens: (4,) of `is_drawn`.
    """
    are_drawn = np.empty(len(seen), np.bool_)
    for n in range(len(places)):
        for k in range(begins[n], begins[n + 1]):
            dx = places[n, 0] - points[seen[k], 0]
            dy = places[n, 1] - points[seen[k], 1]
            dz = places[n, 2] - points[seen[k], 2]
            square = dx * dx + dy * dy + dz * dz
            normal = normals[seen[k]]
            cosine = (dx * normal[0] + dy * normal[1] + dz * normal[2]) / math.sqrt(square)
            are_drawn[k] = math.sqrt(square + lens[3] * lens[3]) <= lens[2] * cosine
    return are_drawn
