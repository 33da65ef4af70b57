"""Draws the camera's effects, each alone and all together: a picture for the page.

python -m flights.photographing.effects_sheet photograph_effects.jpg
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from simulation_tools.camera.defects import beside, decals_of, read_defects
from simulation_tools.camera.effects.amounts import EFFECTS, effects_in
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.geometry import Pose
from simulation_tools.sdf.frames import OPTICAL
from simulation_tools.sdf.parser import load_world

WORLD = Path(__file__).resolve().parents[3] / "worlds/hold_3d.world"
TILE_PX, COLUMNS, BAR_PX = (340, 255), 4, 14
TIMES = 3
"""Each tile is drawn so many times larger, and then made smaller."""
WALL, NEAR = (-8.0, 7.2, 3.0, 75.0), (-9.9, 8.9, 3.0, 100.0)
"""x, y, z, m, and the direction, deg, of the camera: before a frame and its plates, and before a seam."""
SHOWN_FROM = {
    "welds": NEAR,
    "pitting": NEAR,
    "scale": (-7.9, 7.6, 2.3, 75.0),
    "waviness": (-10.6, 9.0, 3.0, 45.0),
    "coatings": (-8.0, 7.2, 1.3, 75.0),
}
"""Small effects are seen from near, waviness along the plate, and the other coatings where one ends."""


def main() -> None:
    """Draw and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("out", type=Path, help="of the picture")
    out = parser.parse_args().out
    marks = read_defects(beside(WORLD))
    surfaces = surfaces_of(load_world(str(WORLD)), marks.coatings)
    decals = decals_of(marks.defects, surfaces)
    optics = CameraOptics(TIMES * TILE_PX[0], TIMES * TILE_PX[1])
    names = ("none", *EFFECTS, "all=0.6")
    width, height = TILE_PX[0], TILE_PX[1] + BAR_PX
    sheet = Image.new("RGB", (COLUMNS * width, -(-len(names) // COLUMNS) * height), "white")
    for number, name in enumerate(names):
        x, y, z, heading = SHOWN_FROM.get(name, WALL)
        pose = Pose.from_xyz_rpy(x, y, z, 0.0, 0.0, math.radians(heading)) @ OPTICAL
        effects = None if name == "none" else effects_in(name)
        picture = (
            Renderer(surfaces, decals, optics, effects).photograph(pose, np.random.default_rng(1)).picture
        )
        at = number % COLUMNS * width, number // COLUMNS * height
        sheet.paste(
            Image.fromarray(picture).resize(TILE_PX, Image.Resampling.LANCZOS), (at[0], at[1] + BAR_PX)
        )
        ImageDraw.Draw(sheet).text((at[0] + 4, at[1] + 1), name, fill="black")
    sheet.save(out, quality=85)


if __name__ == "__main__":
    main()
