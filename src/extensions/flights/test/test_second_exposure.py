"""Given a drawn wall behind a near stanchion, a second exposure shows what the first one blew out."""

import numpy as np

from flights.worlds.writer import Box, Colour, Part, Prop, Surroundings, write_world
from inspection.photographs.metering import metering
from simulation_tools.camera.defects import decals_of
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.geometry import Pose
from simulation_tools.sdf.parser import load_world

LOOKS_ALONG_X = (-0.5, 0.5, -0.5, 0.5)
"""Quaternion x, y, z, w of an optical frame whose z is x, and whose x is -y."""

TOO_BRIGHT_EV = 3.0
"""By so much the first picture is exposed too long."""


def test_what_is_white_is_shown_by_the_second_picture(tmp_path):
    paint = Colour(0.7, 0.72, 0.69)
    wall, stanchion = Box(0.2, 6.0, 3.0), Box(0.05, 0.05, 3.0)
    props = (
        Prop("wall", 2.1, 0.0, (Part("wall", wall, paint, (0.0, 0.0, 1.5)),)),
        Prop("stanchion", 0.6, 0.1, (Part("stanchion", stanchion, paint, (0.0, 0.0, 1.5)),)),
    )
    path = tmp_path / "near.world"
    path.write_text(write_world("near", "A wall behind a stanchion.", Surroundings(paint), props))
    surfaces = surfaces_of(load_world(str(path)))
    renderer = Renderer(surfaces, decals_of((), surfaces), CameraOptics(320, 240, 60.0))
    pose = Pose((0.0, 0.0, 1.5), LOOKS_ALONG_X)
    x, y = np.meshgrid(np.arange(4, 320, 8), np.arange(4, 240, 8))
    pixels = np.column_stack((x.ravel(), y.ravel()))
    pixels = pixels[np.abs(renderer.depths_m(pose, pixels) - 2.0) < 0.01]  # of the wall, which is 2 m ahead
    assert 500 < len(pixels) < 1200  # the stanchion hides the others

    def lost(ev):
        picture = renderer.photograph(pose, np.random.default_rng(1), 0.0, ev).picture
        return metering(picture, pixels, np.ones(len(pixels)))

    first = lost(TOO_BRIGHT_EV)
    assert first.lost > 0.3
    second = lost(TOO_BRIGHT_EV + first.change_ev)
    assert second.lost < 0.02
