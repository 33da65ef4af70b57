"""The rendered camera against a slow reference: each pixel by its own ray, and the light by its formula."""

import math
from dataclasses import replace

import numpy as np
import pytest

from simulation_tools.camera.defects import Defect, decals_of
from simulation_tools.camera.kernels import crack_share
from simulation_tools.camera.metering import Seen, meter
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.geometry import Pose
from simulation_tools.sdf.frames import OPTICAL
from simulation_tools.sdf.parser import load_world

WALL_AT_M, BOX_AT_M = 4.0, 2.0

SDF = """<sdf version="1.6"><world name="wall"><model name="wall"><static>true</static><link name="l">
<visual name="w"><pose>4.5 0 0 0 0 0</pose><geometry><box><size>1 50 50</size></box></geometry></visual>
<visual name="b"><pose>2.5 0 0 0 0 0</pose><geometry><box><size>1 0.5 0.5</size></box></geometry></visual>
</link></model></world></sdf>"""
OPTICS = CameraOptics(160, 120, 60.0, full_well_e=1e6, read_noise_e=0.0, lamp_offset_m=(0.3, 0.0, 0.0))


def surfaces(tmp_path):
    (tmp_path / "wall.world").write_text(SDF)
    return surfaces_of(load_world(str(tmp_path / "wall.world")))


def slow_lux(optics):
    """Illuminance of each pixel (height, width): the wall at x = 4, or the box's face at x = 2."""
    lux = np.zeros((optics.height, optics.width))
    (cx, cy), f = optics.centre_px, optics.focal_px
    lamp = np.array((0.0, -optics.lamp_offset_m[0], 0.0))  # right is -y
    for y in range(optics.height):
        for x in range(optics.width):
            ray = np.array((1.0, -(x - cx) / f, -(y - cy) / f))
            on_box = max(abs(ray[1:])) * BOX_AT_M <= 0.25
            point = ray * (BOX_AT_M if on_box else WALL_AT_M)
            way = point - lamp
            r = np.linalg.norm(way)
            cut = lamp + way * (BOX_AT_M / way[0])  # where the light passes the plane of the box's face
            if on_box or not (abs(cut[1]) < 0.25 and abs(cut[2]) < 0.25):
                lux[y, x] = optics.lamp_cd * (way[0] / r) ** 3 / r**2  # beam squared times Lambert
    return lux


def test_a_picture_is_that_of_the_slow_reference(tmp_path):
    renderer = Renderer(found := surfaces(tmp_path), decals_of((), found), OPTICS)
    shot = renderer.photograph(OPTICAL, np.random.default_rng(1))
    lux = slow_lux(OPTICS)
    lux = lux + OPTICS.ambient * lux.mean()
    y, x = np.indices(lux.shape)
    far = (x - OPTICS.centre_px[0]) ** 2 + (y - OPTICS.centre_px[1]) ** 2
    light = lux * (1.0 - OPTICS.vignetting * far / (OPTICS.centre_px[0] ** 2 + OPTICS.centre_px[1] ** 2))
    light = np.minimum(light * 0.18 / np.median(light), 1.0)
    expected = 255.0 * (1.055 * light ** (1 / 2.4) - 0.055)
    off = np.abs(shot.picture[..., 1] - expected)
    assert np.median(off) < 4.0  # the coating's texture has 5 %: some 3 grey levels
    assert (off < 16.0).mean() > 0.97  # all but the edges, which the lens softens
    assert shot.lux == pytest.approx(lux[60, 80], rel=0.02)


def test_the_speed_follows_the_light(tmp_path):
    found = surfaces(tmp_path)
    speeds = [
        Renderer(found, decals_of((), found), replace(OPTICS, lamp_cd=cd))
        .photograph(OPTICAL, np.random.default_rng(1))
        .iso
        for cd in (24_000.0, 48_000.0)
    ]
    assert speeds[0] == pytest.approx(2.0 * speeds[1])


BOX = "<visual name='{}'><pose>{} 0 0 0</pose><geometry><box><size>{}</size></box></geometry></visual>"
PAST_A_STANCHION = (
    '<sdf version="1.6"><world name="hold"><model name="hold"><static>true</static><link name="l">'
    + BOX.format("plate", "2.5 1 0", "1 1.2 50")
    + BOX.format("far", "40 0 0", "1 200 200")
    + BOX.format("stanchion", "0.95 -0.5 0", "0.1 0.1 9")
    + "</link></model></world></sdf>"
)


def test_what_is_asked_for_is_exposed_past_a_near_stanchion_and_before_a_dark_room(tmp_path):
    """A plate is 2 m away to the left, before a wall 39 m away, and behind a stanchion at 0.9 m."""
    (tmp_path / "hold.world").write_text(PAST_A_STANCHION)
    found = surfaces_of(load_world(str(tmp_path / "hold.world")))
    optics = CameraOptics(160, 120, 90.0, read_noise_e=0.0)
    renderer = Renderer(found, decals_of((), found), optics)
    detail_m = 3.0 / optics.focal_px  # the far wall covers more with each pixel
    plate = np.s_[30:90, 25:60]
    of_all = renderer.photograph(OPTICAL, np.random.default_rng(1)).picture[plate]
    assert np.median(of_all) >= 250  # by the median of all, the plate is white
    shot = renderer.photograph(OPTICAL, np.random.default_rng(1), detail_m)
    assert 60 < np.median(shot.picture[plate]) < 160  # 18 % of white is 118
    lit = renderer.meter(OPTICAL, detail_m).metered
    assert lit.lost < 0.01
    assert lit.iso == shot.iso
    assert renderer.meter(OPTICAL, detail_m, -1.0).metered.iso == pytest.approx(0.5 * shot.iso)


def test_the_median_counts_by_what_is_asked_for_and_by_all_where_nothing_is():
    light = 1000.0 * np.array((4.0, 1.0, 2.0, 3.0))
    seen = Seen(light, light, light, np.array((0.0, 1.0, 1.0, 8.0)))  # the last one is most of the area
    told = meter(seen, 1e-3, 4.0, protects=False)
    assert told.gain * 3000.0 == pytest.approx(0.18)
    of_all = meter(seen._replace(areas_m2=np.zeros(4)), 1e-3, 4.0, protects=False)
    assert of_all.gain * 2500.0 == pytest.approx(0.18)


def test_white_and_black_of_what_is_asked_for_are_kept_from_being_lost():
    """A tenth is ten times as bright as the rest: white by the median, which is lowered by 1 EV at least."""
    light = 1000.0 * np.array([1.0] * 9 + [10.0])
    seen = Seen(light, light, light, np.ones(10))
    plain, kept = (meter(seen, 1e-3, 4.0, protects=each) for each in (False, True))
    assert plain.lost == pytest.approx(0.1)
    assert kept.lost == 0.0
    assert np.log2(kept.gain / plain.gain) == pytest.approx(-1.0)  # 0.18 / 2 * 10 = 0.9 of white


def test_a_crack_fills_its_share_of_a_pixel():
    straight = np.zeros(65, np.float32)
    assert crack_share(0.0, 0.0, 0.5, 0.0005, straight, 0.002) == pytest.approx(0.5)  # 1 mm of 2 mm
    assert crack_share(0.0, 0.001, 0.5, 0.0005, straight, 0.002) == pytest.approx(0.25)  # half beside it
    assert crack_share(0.0, 0.002, 0.5, 0.0005, straight, 0.002) == 0.0
    assert crack_share(0.6, 0.0, 0.5, 0.0005, straight, 0.002) == 0.0


def test_a_crack_and_rust_are_where_the_file_says(tmp_path):
    found = surfaces(tmp_path)
    marks = (
        Defect("rust", (4.0, 1.0, 0.5), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 0.3, 0.3, 5),
        Defect("crack", (4.0, -1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0, 0.05, 5),
    )
    shot = Renderer(found, decals_of(marks, found), OPTICS).photograph(OPTICAL, np.random.default_rng(1))
    (cx, cy), f = OPTICS.centre_px, OPTICS.focal_px

    def pixel(y_m, z_m):
        return shot.picture[round(cy - f * z_m / WALL_AT_M), round(cx - f * y_m / WALL_AT_M)].astype(int)

    red, _, blue = pixel(1.0, 0.5)
    assert red > blue + 25
    plain = pixel(-1.6, 0.0)
    assert abs(plain[0] - plain[2]) < 10
    row = shot.picture[round(cy), :, 1].astype(int)
    at = cx + f / WALL_AT_M  # y = -1 m is to the right
    near = row[round(at) - 6 : round(at) + 7]
    assert near.min() < 0.75 * np.median(near)


def test_nothing_in_view_is_black(tmp_path):
    found = surfaces(tmp_path)
    away = Pose.from_xyz_rpy(0, 0, 0, 0, 0, math.pi) @ OPTICAL
    shot = Renderer(found, decals_of((), found), OPTICS).photograph(away, np.random.default_rng(1))
    assert shot.picture.max() < 12  # read noise at the highest speed
