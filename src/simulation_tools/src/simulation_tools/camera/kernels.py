"""Loops over millions of pixels: light at points, colours in cells, and the sensor."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

GRAIN_M = 0.0005
"""Size of a texel of the coating's grain."""
PATCH_M = 0.02
"""Size of a texel of the coating's patches."""


@njit(cache=True, fastmath=True)
def light(
    pixels: np.ndarray,
    faces: np.ndarray,
    lit: np.ndarray,
    points: np.ndarray,
    axes: np.ndarray,
    offsets: np.ndarray,
    lamp: np.ndarray,
    optical_z: np.ndarray,
    centre: np.ndarray,
    vignetting: float,
    lamp_cd: float,
    out: np.ndarray,
) -> None:
    """Fill out (n, 4): place u, v on the face, m; illuminance by the lamp, lx; what the lens passes.

    pixels: (n, 2). points: (n, 3) in the world. axes: (faces, 3, 3): normal, u, v. lit: whether the lamp's
    light gets there. lamp: (3,). optical_z: (3,) of the lamp's axis. centre: (2,) of the picture, px.
    """
    corner2 = centre[0] ** 2 + centre[1] ** 2
    for k in range(len(faces)):
        dx, dy = pixels[k, 0] - centre[0], pixels[k, 1] - centre[1]
        out[k, 3] = 1.0 - vignetting * (dx * dx + dy * dy) / corner2
        out[k, 0] = out[k, 1] = out[k, 2] = 0.0
        face = faces[k]
        if face < 0:
            continue
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        out[k, 0] = axes[face, 1, 0] * x + axes[face, 1, 1] * y + axes[face, 1, 2] * z
        out[k, 1] = axes[face, 2, 0] * x + axes[face, 2, 1] * y + axes[face, 2, 2] * z
        if lit[k]:
            lx, ly, lz = x - lamp[0], y - lamp[1], z - lamp[2]
            r2 = lx * lx + ly * ly + lz * lz + 1e-6
            r = math.sqrt(r2)
            facing = abs(axes[face, 0, 0] * lx + axes[face, 0, 1] * ly + axes[face, 0, 2] * lz) / r
            beam = max(optical_z[0] * lx + optical_z[1] * ly + optical_z[2] * lz, 0.0) / r
            out[k, 2] = lamp_cd * beam * beam * facing / r2


@njit(cache=True, fastmath=True)
def sample(tile: np.ndarray, u: float, v: float) -> float:
    """Return a tile (side, side) at a place in texels, between the texels; it repeats."""
    side = tile.shape[0]
    fu, fv = math.floor(u), math.floor(v)
    a, b = u - fu, v - fv
    i, j = int(fu) & (side - 1), int(fv) & (side - 1)
    k, m = (i + 1) & (side - 1), (j + 1) & (side - 1)
    low = tile[j, i] * (1 - a) + tile[j, k] * a
    return low * (1 - b) + (tile[m, i] * (1 - a) + tile[m, k] * a) * b


@njit(cache=True, fastmath=True)
def crack_share(
    a: float, b: float, half_length: float, half_width: float, line: np.ndarray, footprint: float
) -> float:
    """Return the share of a pixel that a crack fills. a, b: along and across, m. footprint: of a pixel, m."""
    last = line.shape[0] - 1
    at = (a / half_length + 1.0) * 0.5 * last
    if at <= 0.0 or at >= last:
        return 0.0
    k = int(at)
    middle = line[k] + (line[k + 1] - line[k]) * (at - k)
    slope = (line[k + 1] - line[k]) * last / (2.0 * half_length)
    off = abs(b - middle) / math.sqrt(1.0 + slope * slope)
    taper = min(1.0, 8.0 * min(at, last - at) / last)
    half = max(half_width * taper, 1e-5)
    low, high = max(off - 0.5 * footprint, -half), min(off + 0.5 * footprint, half)
    return max(high - low, 0.0) / footprint


@njit(cache=True, fastmath=True)
def marked(
    u: float,
    v: float,
    rgb: np.ndarray,
    first: int,
    last: int,
    kind: np.ndarray,
    place: np.ndarray,
    shift: np.ndarray,
    lines: np.ndarray,
    clouds: np.ndarray,
    footprint: float,
) -> None:
    """Change the albedo rgb (3,) by the marks first..last of a face, at a place u, v, m."""
    for d in range(first, last):
        du, dv = u - place[d, 0], v - place[d, 1]
        a, b = du * place[d, 2] + dv * place[d, 3], -du * place[d, 3] + dv * place[d, 2]
        hl, hw = place[d, 4], place[d, 5]
        if kind[d] == 1:
            if abs(a) < hl and abs(b) < 0.3 * hl + 0.01:
                share = 0.94 * crack_share(a, b, hl, hw, lines[d], footprint)
                for c in range(3):
                    rgb[c] *= 1.0 - share
        elif kind[d] == 2:
            if abs(a) < hl and abs(b) < hw:
                bump = b / hw
                shade = 1.0 + 0.5 * bump * (1.0 - bump * bump)
                if footprint < 0.003:
                    shade += 0.08 * math.sin(a * 1000.0)
                for c in range(3):
                    rgb[c] *= shade
        elif abs(a) < 1.6 * hl and abs(b) < 1.6 * hw:
            far = math.sqrt((a / hl) ** 2 + (b / hw) ** 2)
            scale = 60.0 / max(hl, hw)
            rough = sample(clouds, a * scale + shift[d, 0], b * scale + shift[d, 1])
            if kind[d] == 0:
                much = min(max((1.0 - far - 0.22 * rough) * 6.0, 0.0), 1.0)
                pits = sample(clouds, a * 700.0 + shift[d, 1], b * 700.0 + shift[d, 0])
                tone = min(max(0.5 + 0.3 * pits + 0.15 * rough, 0.0), 1.0)
                rgb[0] += much * (0.08 + 0.22 * tone - rgb[0])
                rgb[1] += much * (0.022 + 0.075 * tone - rgb[1])
                rgb[2] += much * (0.010 + 0.018 * tone - rgb[2])
            else:
                much = min(max((1.0 - far - 0.15 * rough) * 1.6, 0.0), 1.0)
                red, green, blue = (0.22, 0.27, 0.33) if kind[d] == 3 else (0.45, 0.45, 0.45)
                rgb[0] *= 1.0 - much * red
                rgb[1] *= 1.0 - much * green
                rgb[2] *= 1.0 - much * blue


@njit(cache=True, fastmath=True)
def _near(u: float, v: float, radius: float, place: np.ndarray, kind: np.ndarray, d: int) -> bool:
    """Whether a mark may touch a circle."""
    du, dv = u - place[d, 0], v - place[d, 1]
    a, b = du * place[d, 2] + dv * place[d, 3], -du * place[d, 3] + dv * place[d, 2]
    wide = place[d, 5] if kind[d] == 2 else 1.6 * place[d, 5]
    if kind[d] == 1:
        wide = 0.3 * place[d, 4] + 0.01
    return abs(a) < 1.6 * place[d, 4] + radius and abs(b) < wide + radius


@njit(cache=True, fastmath=True)
def fill(
    picture: np.ndarray,
    x0: int,
    y0: int,
    size: int,
    face: int,
    corners: np.ndarray,
    albedos: np.ndarray,
    marks: tuple,
    tiles: np.ndarray,
    clouds: np.ndarray,
    gain: float,
    ambient: float,
) -> None:
    """Fill a cell of the picture (height, width, 3), uint16, whose corners lie on one face.

    corners: (4, 4): `light` at top left, top right, bottom left, bottom right. marks: the `Decals`.
    """
    height, width = picture.shape[:2]
    if face < 0:
        for y in range(y0, min(y0 + size, height)):
            for x in range(x0, min(x0 + size, width)):
                picture[y, x, 0] = picture[y, x, 1] = picture[y, x, 2] = 0
        return
    first, kind, place, shift, lines = marks
    u, v = 0.5 * (corners[0, 0] + corners[3, 0]), 0.5 * (corners[0, 1] + corners[3, 1])
    across = math.hypot(corners[1, 0] - corners[0, 0], corners[1, 1] - corners[0, 1])
    down = math.hypot(corners[2, 0] - corners[0, 0], corners[2, 1] - corners[0, 1])
    footprint = max(max(across, down) / size, 1e-6)
    low, high = first[face + 1], first[face]
    for d in range(first[face], first[face + 1]):
        if _near(u, v, across + down, place, kind, d):
            low, high = min(low, d), d + 1
    level = min(max(int(math.log2(footprint / GRAIN_M)), 0), tiles.shape[0] - 1)
    tile = tiles[level]
    patches = 1.0 + 0.035 * sample(clouds, u / PATCH_M, v / PATCH_M)
    rgb = np.empty(3, np.float64)
    inverse = 1.0 / size
    for y in range(y0, min(y0 + size, height)):
        t = (y - y0) * inverse
        left, right = corners[0] * (1 - t) + corners[2] * t, corners[1] * (1 - t) + corners[3] * t
        for x in range(x0, min(x0 + size, width)):
            s = (x - x0) * inverse
            u, v = left[0] + (right[0] - left[0]) * s, left[1] + (right[1] - left[1]) * s
            lux = left[2] + (right[2] - left[2]) * s + ambient
            strength = gain * lux * (left[3] + (right[3] - left[3]) * s) * patches
            strength *= 1.0 + 0.04 * sample(tile, u / GRAIN_M, v / GRAIN_M)
            rgb[0], rgb[1], rgb[2] = albedos[face, 0], albedos[face, 1], albedos[face, 2]
            if low < high:
                marked(u, v, rgb, low, high, kind, place, shift, lines, clouds, footprint)
            for c in range(3):
                picture[y, x, c] = np.uint16(min(max(strength * rgb[c], 0.0), 65535.0))


@njit(cache=True)
def mixed_cells(faces: np.ndarray, lit: np.ndarray, out: np.ndarray) -> None:
    """Fill out (rows - 1, columns - 1): whether the corners of a cell differ in face or light."""
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            f, b = faces[y, x], lit[y, x]
            out[y, x] = (
                faces[y, x + 1] != f or faces[y + 1, x] != f or faces[y + 1, x + 1] != f
                or lit[y, x + 1] != b or lit[y + 1, x] != b or lit[y + 1, x + 1] != b
            )  # fmt: skip


@njit(cache=True, fastmath=True)
def fill_grid(
    picture: np.ndarray,
    faces: np.ndarray,
    mixed: np.ndarray,
    lights: np.ndarray,
    step: int,
    albedos: np.ndarray,
    marks: tuple,
    tiles: np.ndarray,
    clouds: np.ndarray,
    gain: float,
    ambient: float,
) -> None:
    """Fill all cells of a grid that are not mixed. faces: (rows, columns). lights: (rows, columns, 4)."""
    corners = np.empty((4, 4))
    for row in range(mixed.shape[0]):
        for column in range(mixed.shape[1]):
            if not mixed[row, column]:
                corners[0], corners[1] = lights[row, column], lights[row, column + 1]
                corners[2], corners[3] = lights[row + 1, column], lights[row + 1, column + 1]
                fill(picture, column * step, row * step, step, faces[row, column], corners,
                     albedos, marks, tiles, clouds, gain, ambient)  # fmt: skip


@njit(cache=True, fastmath=True)
def fill_patches(
    picture: np.ndarray,
    places: np.ndarray,
    faces: np.ndarray,
    lit: np.ndarray,
    lights: np.ndarray,
    albedos: np.ndarray,
    marks: tuple,
    tiles: np.ndarray,
    clouds: np.ndarray,
    gain: float,
    ambient: float,
) -> None:
    """Fill mixed cells of 8 x 8 px, in sub-cells of 4, 2 and 1.

    faces, lit: (n, 9, 9). places: (n, 2), x and y of their corners.
    """
    corners = np.empty((4, 4))
    for k in range(len(places)):
        for size in (4, 2, 1):
            for y in range(0, 8, size):
                for x in range(0, 8, size):
                    if size < 4 and agree(faces[k], lit[k], x // (2 * size) * (2 * size),
                                          y // (2 * size) * (2 * size), 2 * size):  # fmt: skip
                        continue
                    if size == 2 and agree(faces[k], lit[k], x // 4 * 4, y // 4 * 4, 4):
                        continue
                    if size == 1 and agree(faces[k], lit[k], x // 4 * 4, y // 4 * 4, 4):
                        continue
                    if size > 1:
                        if not agree(faces[k], lit[k], x, y, size):
                            continue
                        corners[0], corners[1] = lights[k, y, x], lights[k, y, x + size]
                        corners[2], corners[3] = lights[k, y + size, x], lights[k, y + size, x + size]
                    else:
                        corners[0] = corners[1] = corners[2] = corners[3] = lights[k, y, x]
                        corners[1, 0] += 0.001
                    fill(picture, places[k, 0] + x, places[k, 1] + y, size, faces[k, y, x], corners,
                         albedos, marks, tiles, clouds, gain, ambient)  # fmt: skip


@njit(cache=True)
def agree(faces: np.ndarray, lit: np.ndarray, x: int, y: int, size: int) -> bool:
    """Whether the corners of a sub-cell lie on one face, and all in light or all in shadow."""
    f, b = faces[y, x], lit[y, x]
    return (
        faces[y, x + size] == f and faces[y + size, x] == f and faces[y + size, x + size] == f
        and lit[y, x + size] == b and lit[y + size, x] == b and lit[y + size, x + size] == b
    )  # fmt: skip


@njit(cache=True)
def wanted(faces: np.ndarray, lit: np.ndarray, known: np.ndarray, size: int, out: np.ndarray) -> None:
    """Fill out (n, 9, 9): which points to ask next, the corners of sub-cells of this size (4, 2 or 1)."""
    for k in range(len(faces)):
        for y in range(0, 8, 2 * size):
            for x in range(0, 8, 2 * size):
                if size < 4 and not (known[k, y, x] and known[k, y, x + 2 * size]
                                     and known[k, y + 2 * size, x]
                                     and known[k, y + 2 * size, x + 2 * size]):  # fmt: skip
                    continue
                if agree(faces[k], lit[k], x, y, 2 * size):
                    continue
                for b in range(3):
                    for a in range(3):
                        if not known[k, y + b * size, x + a * size]:
                            out[k, y + b * size, x + a * size] = True


@njit(cache=True, fastmath=True)
def develop(
    raw: np.ndarray,
    grain: np.ndarray,
    starts: np.ndarray,
    sigma: np.ndarray,
    gamma: np.ndarray,
    out: np.ndarray,
) -> None:
    """Turn linear uint16 (height, width, 3) into uint8: the lens's softness, noise, and the display's curve.

    starts: (height,) where each row reads its noise. sigma: (4096,) by value >> 4. gamma: (4096,) uint8.
    """
    height, width = raw.shape[:2]
    mask = len(grain) - 1
    row = np.empty(3 * width + 6, np.float32)
    for y in range(height):
        up, down = max(y - 1, 0), min(y + 1, height - 1)
        for x in range(width):
            for c in range(3):
                total = np.float32(raw[up, x, c]) + np.float32(raw[down, x, c])
                row[3 * x + 3 + c] = np.float32(0.125) * total + np.float32(0.75) * np.float32(raw[y, x, c])
        for c in range(3):
            row[c], row[3 * width + 3 + c] = row[3 + c], row[3 * width + c]
        at = starts[y]
        for x in range(width):
            for c in range(3):
                k = 3 * x + c
                value = np.float32(0.125) * (row[k] + row[k + 6]) + np.float32(0.75) * row[k + 3]
                value += sigma[int(value) >> 4] * grain[(at + k) & mask]
                out[y, x, c] = gamma[min(max(int(value), 0), 65535) >> 4]
