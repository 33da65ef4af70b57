"""The camera's effects: each lies where its formula says, on the world and not on the picture."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import yaml
from scipy.ndimage import binary_dilation

from simulation_tools.camera.defects import decals_of, read_defects
from simulation_tools.camera.effects.amounts import EFFECTS, Effects, effects_in, effects_of
from simulation_tools.camera.effects.colour import LOW, run
from simulation_tools.camera.effects.layout import layout_of, upper_edges
from simulation_tools.camera.effects.lens import drops_and_fog, mix
from simulation_tools.camera.effects.relief import BEAD_HEIGHT_M, DISH_HEIGHT_M, DISH_M, bead, height
from simulation_tools.camera.effects.shading import shade
from simulation_tools.camera.errors import PhotographError
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import linear, surfaces_of
from simulation_tools.geometry import Pose
from simulation_tools.sdf.frames import OPTICAL
from simulation_tools.sdf.parser import load_world

BOX = "<visual name='{}'><pose>{} 0 0 0</pose><geometry><box><size>{}</size></box></geometry></visual>"
SDF = (
    '<sdf version="1.6"><world name="wall"><model name="wall"><static>true</static><link name="l">'
    + BOX.format("wall", "4.5 0 0", "1 50 50")
    + BOX.format("box", "2.5 1.5 0", "1 0.5 0.5")
    + "</link></model></world></sdf>"
)
"""A wall at x = 4 m, and a box before it, to the left."""
OPTICS = CameraOptics(320, 240, 60.0, full_well_e=1e6, read_noise_e=0.0, lamp_offset_m=(0.3, 0.0, 0.0))
FINE = replace(OPTICS, width=640, height=480)
FOCAL, (CX, CY) = OPTICS.focal_px, OPTICS.centre_px


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    path = tmp_path_factory.mktemp("world") / "wall.world"
    path.write_text(SDF)
    return surfaces_of(load_world(str(path)))


@pytest.fixture(scope="module")
def shot(wall):
    """Return linear light (height, width, 3), in which a photograph is the same if the exposure is."""

    @cache
    def taken(effects=None, xyz=(0.0, 0.0, 0.0), optics=OPTICS):
        pose = Pose.from_xyz_rpy(*xyz) @ OPTICAL
        renderer = Renderer(wall, decals_of((), wall), optics, effects)
        return linear(renderer.photograph(pose, np.random.default_rng(1)).picture / 255.0)

    return taken


def test_none_of_each_effect_changes_nothing(shot):
    assert (shot(Effects(seed=4)) == shot()).all()


@pytest.mark.table("name", EFFECTS)
def test_each_effect_changes_a_picture(shot, name):
    place = (1.0, 1.0, 0.0)
    assert (np.abs(shot(effects_of({name: 1.0}), place) - shot(None, place)) > 0.01).any()


def test_a_bead_lies_along_its_seam_and_turns_its_upper_side_to_a_lamp_above(wall, shot):
    """The seam is at v = z. The slope of a parabola is greatest at its edge, 6 mm from the seam."""
    effects = Effects(welds=1.0)
    at = layout_of(effects, wall).seams_m
    optics = CameraOptics(640, 480, 20.0, full_well_e=1e6, read_noise_e=0.0, lamp_offset_m=(0.0, -1.5, 0.0))
    place = (3.0, -float(at[0]) + 1.0, float(at[1]))  # 1 m before the wall; the upright seam is elsewhere
    changed = shot(effects, place, optics)[..., 1].mean(axis=1) / shot(None, place, optics)[..., 1].mean(
        axis=1
    )
    row, bead_px = optics.centre_px[1], 0.006 * optics.focal_px
    assert row - bead_px - 2 <= np.argmax(changed) < row  # rows count down
    assert row < np.argmin(changed) <= row + bead_px + 2
    beside = np.abs(np.arange(480) - row) > bead_px + 6
    assert np.abs(changed[beside] - 1.0).max() < 0.05


def test_relief_by_its_formulas(wall):
    assert bead(0.0, 0.0, 1.0) == pytest.approx(BEAD_HEIGHT_M, rel=1e-3)  # so far away no ripple is seen
    assert bead(0.003, 0.0, 1.0) == pytest.approx(0.75 * BEAD_HEIGHT_M, rel=1e-2)
    assert bead(0.006, 0.0, 1.0) == 0.0
    layout = layout_of(Effects(waviness=0.5), wall)
    args = (layout.amounts, 0, layout.seams_m, layout.shifts[0], layout.clouds, 0.001)
    assert height(DISH_M / 4, DISH_M / 4, *args) == pytest.approx(0.5 * DISH_HEIGHT_M)
    assert height(0.0, 0.1, *args) == pytest.approx(0.0, abs=1e-9)
    slope, lamp = math.radians(20.0), math.radians(50.0)  # both lean along u
    expected = math.cos(lamp + slope) / math.cos(lamp)
    assert shade(math.tan(slope), 0.0, math.sin(lamp), 0.0, math.cos(lamp)) == pytest.approx(expected)


def test_a_wet_wall_mirrors_the_lamp_where_the_law_of_reflection_says(shot):
    """The line from the eye to the lamp's mirror image meets the wall half as far aside as the lamp is."""
    place = (1.0, -3.0, 0.0)
    wet = shot(Effects(wet=1.0), place)
    gain = wet[..., 1] - np.median(wet[..., 1])
    y, x = np.nonzero(gain > 0.5 * gain.max())
    assert x.mean() == pytest.approx(CX + FOCAL * 0.15 / 3.0, abs=2.0)
    assert y.mean() == pytest.approx(CY, abs=2.0)


def test_runs_hang_below_the_upper_edge_of_a_box(wall, shot):
    first, edges = upper_edges(wall)
    front = int(wall.nearest(np.array([[0.0, 1.5, 0.0]]), np.array([[1.0, 0.0, 0.0]]))[0][0])
    (edge,) = edges[first[front] : first[front + 1]]
    middle = 1.5 * wall.u_axes[front, 1]
    assert edge == pytest.approx((middle - 0.25, middle + 0.25, 0.25))
    place = (0.5, 1.5, 0.0)
    # The meter sees the runs, too, so all of the bright face changes a little.
    changed = np.abs(shot(Effects(runs=1.0), place) - shot(None, place))[..., 1] > 0.15
    half = int(0.25 * FOCAL / 1.5)  # of the box's face, 1.5 m away
    face = changed[:, round(CX) - half + 2 : round(CX) + half - 2]
    top, bottom = round(CY) - half, round(CY) + half
    assert face[top + 2 : bottom].any()
    started = binary_dilation(face[top + 2 : top + 8].any(axis=0), iterations=3)  # runs sway by 4 mm, 1 px
    assert (face[top + 8 : bottom].any(axis=0) <= started).all()  # each begins at the edge


def test_a_run_ends_where_it_is_thin():
    dense = np.array(
        [[run(u, drop, 3, 1.0, 0) for u in np.arange(0.0, 2.0, 0.005)] for drop in (0.01, 0.6, 1.3)]
    )
    assert dense[0].max() > dense[1].max() > 0.0
    assert not dense[2].any()
    assert run(0.5, -0.01, 3, 1.0, 0) == 0.0  # above the edge


def test_two_photographs_of_one_place_show_the_same_plate(shot):
    effects = Effects(dirt=1.0, patches=1.0, scale=1.0, runs=1.0, seed=5)
    tints = []
    y_m, z_m = np.meshgrid(np.linspace(-1.2, 0.2, 40), np.linspace(-0.5, 0.5, 30))
    for x, y, z in ((1.0, -0.4, 0.0), (1.4, -0.6, 0.1)):
        far = 4.0 - x
        row = np.rint(FINE.centre_px[1] - FINE.focal_px * (z_m - z) / far)
        column = np.rint(FINE.centre_px[0] - FINE.focal_px * (y_m - y) / far)
        index = row.astype(int), column.astype(int)
        tints.append(shot(effects, (x, y, z), FINE)[index] / shot(None, (x, y, z), FINE)[index])
    first, second = (each[..., 1] / np.median(each[..., 1]) for each in tints)
    assert first.std() > 0.1
    assert np.corrcoef(first.ravel(), second.ravel())[0, 1] > 0.9


def test_the_meter_sees_the_effects(wall):
    """All that is in view lies below the band, so each point has the low coating's light."""
    pose = Pose.from_xyz_rpy(0.0, 0.0, -10.0) @ OPTICAL
    isos = [
        Renderer(wall, decals_of((), wall), OPTICS, each).meter(pose).metered.iso
        for each in (None, Effects(coatings=1.0))
    ]
    assert isos[1] / isos[0] == pytest.approx(1.0 / (LOW @ (0.2126, 0.7152, 0.0722)), rel=1e-3)


def test_condensation_is_a_mixture_and_stays_on_the_lens():
    rng = np.random.default_rng(3)
    raw = rng.integers(0, 60_000, (8, 9, 3)).astype(np.uint16)
    blurred, covered = rng.random((8, 9, 3), np.float32) * 6e4, rng.random((8, 9), np.float32)
    expected = raw * (1.0 - covered[..., None]) + covered[..., None] * blurred
    mixed = raw.copy()
    mix(mixed, blurred, covered, 1)
    assert np.abs(mixed - expected).max() <= 1.0
    first, second = drops_and_fog((60, 80), 1.0, 7), drops_and_fog((60, 80), 1.0, 7)
    assert (first == second).all()
    assert 0.3 < first.max() <= 0.9
    assert not drops_and_fog((60, 80), 0.0, 7).any()


def test_words_and_a_file_name_the_effects(tmp_path):
    assert effects_in("dirt=0.5, runs seed=3") == Effects(dirt=0.5, runs=1.0, seed=3)
    assert effects_in("all=0.5 wet=0") == effects_of({**dict.fromkeys(EFFECTS, 0.5), "wet": 0.0})
    assert effects_in(str(Effects(dirt=0.25, seed=9))) == Effects(dirt=0.25, seed=9)
    assert not effects_in("").is_any
    path = tmp_path / "a.defects.yaml"
    path.write_text(yaml.safe_dump({"defects": [], "effects": {"dirt": 0.5}}))
    assert read_defects(path).effects == Effects(dirt=0.5)


@pytest.mark.table(
    ("words", "said"),
    [("rain", 'no effect "rain"'), ("dirt=2", "effect dirt must be between 0 and 1, not 2.0"),
     ("dirt=much", "has no number"),
     ("dirt=nan", "dirt must be a finite number"),
     ("seed=-1", "seed must be at least 0, not -1"), ("seed=0.5", "seed must be a whole number, not 0.5")],
)  # fmt: skip
def test_bad_effects_are_refused_with_a_sentence(tmp_path, words, said):
    with pytest.raises(PhotographError, match=said):
        effects_in(words)
    path = tmp_path / "a.defects.yaml"
    path.write_text(
        yaml.safe_dump({"defects": [], "effects": dict([words.split("=") if "=" in words else (words, 1)])})
    )
    with pytest.raises(PhotographError, match=r"a\.defects\.yaml, line "):
        read_defects(path)
