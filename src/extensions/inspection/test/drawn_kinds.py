"""Small drawn pictures of things that are red, brown or gold and no rust, and of rust on several coatings.

Each takes a seed and returns uint8 (SIDE, SIDE, 3), sRGB.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

SIDE = 240
Y, X = np.mgrid[:SIDE, :SIDE].astype(float)


def noise(rng, scale_px, along=None):
    """Smooth noise of the deviation 1. along: its scale along y, if another."""
    raw = ndimage.gaussian_filter(rng.normal(size=(SIDE, SIDE)), (along or scale_px, scale_px), mode="wrap")
    return raw / raw.std()


def tinted(colour, light=1.0, hue=None, rng=None):
    """A colour, of which light (SIDE, SIDE) is a multiple; hue: a second colour and its share, too."""
    picture = np.ones((SIDE, SIDE, 1)) * np.array(colour, float)
    if hue is not None:
        other, share = hue
        share = np.clip(share, 0.0, 1.0)[..., None]
        picture = picture * (1.0 - share) + np.array(other, float) * share
    picture = picture * np.broadcast_to(light, (SIDE, SIDE))[..., None]
    return np.clip(picture + rng.normal(0.0, 2.0, picture.shape), 0, 255).astype(np.uint8)


def over(below, above, share):
    """One picture over another where share, (SIDE, SIDE), is 1."""
    share = np.clip(share, 0.0, 1.0)[..., None]
    return (below * (1.0 - share) + above * share).astype(np.uint8)


def boot_top(seed):
    """Red boot-top below a grey side, with the waterline's dirt."""
    rng = np.random.default_rng(seed)
    red = tinted((150, 40, 38), np.exp(0.05 * noise(rng, 40)), rng=rng)
    grey = tinted((120, 124, 128), np.exp(0.05 * noise(rng, 40)), rng=rng)
    return over(grey, red, (Y - 2 * noise(rng, 30) > 90) * 1.0)


def car_paint(seed):
    """A curved red door with a highlight and the edge of another door."""
    rng = np.random.default_rng(seed)
    light = 0.6 + 0.4 * np.cos((Y - 80) / 60.0)
    picture = tinted((190, 22, 30), np.maximum(light, 0.15), rng=rng)
    shine = np.exp(-0.5 * ((Y - 70 - 0.1 * X) / 8.0) ** 2)
    picture = over(picture, np.full_like(picture, 245), 0.8 * shine)
    picture[:, 150:153] = (30, 6, 8)
    return picture


def gold(seed):
    """A gilded bowl: smooth yellow that runs from brown to white."""
    rng = np.random.default_rng(seed)
    far = np.hypot(X - 120, Y - 120)
    light = np.clip(1.3 - far / 110.0 + 0.25 * np.sin(far / 7.0 + X / 30.0), 0.15, 1.3)
    picture = tinted((205, 150, 60), light, rng=rng)
    return over(np.full_like(picture, 235), picture, (far < 100) * 1.0)


def grass(seed):
    """Blades, green to straw."""
    rng = np.random.default_rng(seed)
    blades = noise(rng, 1.0, 6.0)
    return tinted((90, 120, 45), np.exp(0.4 * blades), ((165, 150, 80), 0.4 + 0.3 * noise(rng, 3, 9)), rng)


def brick(seed):
    """Red bricks in mortar, each with its own tone."""
    rng = np.random.default_rng(seed)
    row = (Y // 24).astype(int)
    x = X + 24 * (row % 2)
    tone = rng.normal(0.0, 0.12, (12, 8))[row, (x // 48).astype(int)]
    wall = tinted((160, 78, 58), np.exp(tone + 0.06 * noise(rng, 1.0)), rng=rng)
    mortar = tinted((180, 175, 165), np.exp(0.05 * noise(rng, 1.0)), rng=rng)
    return over(wall, mortar, ((Y % 24 < 4) | (x % 48 < 4)) * 1.0)


def wood(seed):
    """Planks with their grain."""
    rng = np.random.default_rng(seed)
    bend = 6.0 * noise(rng, 8.0, 60.0)
    grain = np.sin((X + bend) / 2.2) * 0.12 + 0.06 * noise(rng, 0.8, 20.0)
    picture = tinted((150, 100, 60), np.exp(grain), rng=rng)
    picture[:, ::60] = (50, 32, 18)
    return picture


def skin(seed):
    """A face's cheek: smooth, with pores."""
    rng = np.random.default_rng(seed)
    light = 1.0 - 0.4 * np.hypot(X - 90, Y - 100) / 200.0
    return tinted(
        (215, 160, 130), light * np.exp(0.015 * noise(rng, 1.5)), ((190, 110, 95), 0.3 * noise(rng, 40)), rng
    )


def leaves(seed):
    """Autumn leaves: yellow, orange and red patches, with dark gaps."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(0, SIDE, (160, 2))
    near = np.argmin((X[..., None] - places[:, 0]) ** 2 + (Y[..., None] - places[:, 1]) ** 2, axis=2)
    tones = np.array([(215, 150, 30), (200, 90, 20), (180, 40, 25), (120, 110, 30)], float)
    picture = tones[rng.integers(0, 4, 160)][near] * np.exp(rng.normal(0, 0.2, 160))[near][..., None]
    edge = ndimage.maximum_filter(near, 3) != ndimage.minimum_filter(near, 3)
    picture[edge] *= 0.35
    return np.clip(picture + rng.normal(0, 3, picture.shape), 0, 255).astype(np.uint8)


def leather(seed):
    """A brown bag with the grain of its skin."""
    rng = np.random.default_rng(seed)
    grain = np.minimum(noise(rng, 2.0), 0.3)
    return tinted((120, 70, 42), np.exp(0.12 * grain + 0.1 * noise(rng, 40)), rng=rng)


def tomatoes(seed):
    """Three tomatoes with their shine and stalks on a white plate."""
    rng = np.random.default_rng(seed)
    picture = tinted((225, 222, 215), np.exp(0.03 * noise(rng, 20)), rng=rng)
    for x, y, radius in ((70, 80, 50), (160, 100, 55), (110, 180, 45)):
        far = np.hypot(X - x, Y - y)
        light = 0.8 * np.sqrt(np.clip(1.0 - (far / radius) ** 2, 0, 1)) + 0.25
        picture = over(picture, tinted((205, 45, 28), light, rng=rng), (far < radius) * 1.0)
        shine = np.exp(-0.5 * (np.hypot(X - x + 15, Y - y + 18) / 5.0) ** 2)
        picture = over(picture, np.full_like(picture, 250), 0.8 * shine)
        picture = over(picture, tinted((60, 110, 40), rng=rng), (far < 9) * 1.0)
    return picture


def tiles(seed):
    """A roof of terracotta."""
    rng = np.random.default_rng(seed)
    light = (0.6 + 0.5 * np.sin(np.pi * (X % 40) / 40.0)) * np.where(Y % 30 < 4, 0.5, 1.0)
    tone = rng.normal(0.0, 0.1, (9, 7))[(Y // 30).astype(int), (X // 40).astype(int)]
    return tinted((190, 98, 66), light * np.exp(tone + 0.05 * noise(rng, 1.0)), rng=rng)


def sunset(seed):
    """A sky from orange to violet over dark water."""
    rng = np.random.default_rng(seed)
    sky = tinted(
        (240, 140, 60), 1.0 - Y / 500.0, ((120, 70, 110), 1.0 - Y / 150.0 + 0.05 * noise(rng, 30, 5)), rng
    )
    sea = tinted((80, 45, 35), np.exp(0.3 * noise(rng, 8.0, 1.0)), rng=rng)
    return over(sky, sea, (Y > 170) * 1.0)


def containers(seed):
    """Red-brown containers with upright ribs, their gaps and a white word."""
    rng = np.random.default_rng(seed)
    picture = tinted((145, 52, 40), 1.0 + 0.18 * np.sign(np.sin(X / 3.0)), rng=rng)
    picture[::80] = picture[1::80] = (25, 15, 14)
    picture[100:112, 40:130] = (225, 220, 215)
    return picture


def life_ring(seed):
    """An orange ring with white bands on a white wall."""
    rng = np.random.default_rng(seed)
    far, angle = np.hypot(X - 120, Y - 120), np.arctan2(Y - 120, X - 120)
    ring = tinted((235, 95, 25), 0.7 + 0.3 * np.cos((far - 70) / 20.0), rng=rng)
    wall = tinted((225, 226, 222), np.exp(0.02 * noise(rng, 30)), rng=rng)
    return over(wall, ring, (np.abs(far - 70) < 24) & (np.abs(np.sin(2 * angle)) > 0.35))


def rusted(seed, share, coating):
    """Rust over a coating, where share (SIDE, SIDE) is more than 0.5: brown to orange, mottled, dark pits."""
    rng = np.random.default_rng(seed + 99)
    light = np.exp(0.22 * noise(rng, 1.2) + 0.15 * noise(rng, 5.0))
    rust = tinted((140, 78, 44), light, ((95, 52, 34), 0.4 + 0.35 * noise(rng, 3.0)), rng)
    return over(coating, rust, (share - 0.5) * 6.0 + 0.5)


def coated(seed, colour):
    """A plate with a little dirt."""
    rng = np.random.default_rng(seed)
    return tinted(colour, np.exp(0.03 * noise(rng, 30) + 0.01 * noise(rng, 1.0)), rng=rng)


def patches(seed):
    return 0.5 + 0.5 * (noise(np.random.default_rng(seed + 5), 14.0) - 0.5)


def on_grey(seed):
    return rusted(seed, patches(seed), coated(seed, (135, 138, 140)))


def on_white(seed):
    return rusted(seed, patches(seed), coated(seed, (222, 222, 216)))


def on_green(seed):
    return rusted(seed, patches(seed), coated(seed, (70, 110, 80)))


def on_red(seed):
    return rusted(seed, patches(seed), coated(seed, (140, 42, 38)))


def runs(seed):
    """Runs below a weld: narrow, strong at their upper end."""
    rng = np.random.default_rng(seed)
    share = np.zeros((SIDE, SIDE))
    for x, length, width in zip(rng.uniform(10, 230, 14), rng.uniform(50, 150, 14), rng.uniform(3, 8, 14)):
        down = Y - 60
        wide = width * np.clip(1.0 - down / length, 0.0, 1.0)
        share = np.maximum(share, (np.abs(X - x - 2.0 * np.sin(Y / 30.0)) < wide) * (down > 0) * 0.9)
    share = np.maximum(share, (np.abs(Y - 57) < 5) * 0.9)
    return rusted(seed, ndimage.gaussian_filter(share, 1.0), coated(seed, (150, 152, 150)))


def scale(seed):
    """Rust all over, with flakes that stand off and throw shadows."""
    rng = np.random.default_rng(seed)
    picture = rusted(seed, np.ones((SIDE, SIDE)), coated(seed, (150, 150, 150))).astype(float)
    flakes = (noise(rng, 6.0) > 0.4).astype(float)
    shadow = np.clip(np.roll(flakes, (3, 3), (0, 1)) - flakes, 0, 1)
    return np.clip(picture * (1.0 - 0.6 * shadow + 0.15 * flakes)[..., None], 0, 255).astype(np.uint8)


def pitting(seed):
    """Many rusted pits with their rims on a light plate."""
    rng = np.random.default_rng(seed)
    share = np.zeros((SIDE, SIDE))
    for x, y, radius in zip(*rng.uniform(8, 232, (2, 26)), rng.uniform(6, 13, 26)):
        share = np.maximum(share, 1.0 - np.hypot(X - x, Y - y) / (2.0 * radius))
    return rusted(seed, share + 0.05 * noise(rng, 2.0), coated(seed, (170, 170, 165)))


def wet(seed):
    """Rust that is darker, and shines in places."""
    rng = np.random.default_rng(seed)
    dark = (on_grey(seed) * np.array((0.6, 0.55, 0.55))).astype(np.uint8)
    shine = np.exp(-0.5 * ((X - 80 + 10 * noise(rng, 20)) / 4.0) ** 2) * (noise(rng, 6) > 0)
    return over(dark, np.full_like(dark, 235), 0.7 * shine)


def in_shadow(seed):
    """Rust half in the shadow of a frame."""
    return (on_grey(seed) * np.where(X + 0.3 * Y > 150, 0.3, 1.0)[..., None]).astype(np.uint8)


def under_blue_light(seed):
    return np.clip(on_grey(seed) * np.array((0.8, 0.95, 1.15)), 0, 255).astype(np.uint8)


NO_RUST = (
    boot_top, car_paint, gold, grass, brick, wood, skin, leaves, leather, tomatoes, tiles, sunset, containers,
    life_ring,
)  # fmt: skip
RUST = (on_grey, on_white, on_green, on_red, runs, scale, pitting, wet, in_shadow, under_blue_light)
