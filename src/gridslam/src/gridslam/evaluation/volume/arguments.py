"""The sub-command ``gridslam_evaluate volume``."""

from __future__ import annotations

import argparse
from pathlib import Path

from gridslam.errors import EvaluationError
from gridslam.evaluation.argument_types import finite, positive
from gridslam.evaluation.volume.lidars import VIEWS
from mesh_files import KINDS

OF_PATH = ("lidar", "elevation", "field_of_view", "range", "lidar_at")
"""Options that say nothing without a path."""


def add_volume_arguments(parser: argparse.ArgumentParser) -> None:
    """Tell a parser the arguments, and what judges them."""
    parser.add_argument("map", type=Path, help="map to judge, .bt or .ot")
    parser.add_argument("world", type=Path, help=KINDS)
    parser.add_argument(
        "--path", type=Path, help="true poses of the lidar in the world, TUM form with heights"
    )
    parser.add_argument("--lidar", choices=tuple(VIEWS), help="lidar that saw from there")
    parser.add_argument(
        "--elevation",
        type=finite,
        nargs=2,
        metavar=("LOW", "HIGH"),
        help="lowest and highest beam of another lidar, deg (default: all around)",
    )
    parser.add_argument(
        "--field-of-view", type=positive, metavar="DEG", help="in its plane, deg (default: 360)"
    )
    parser.add_argument("--range", type=positive, metavar="M", help="its range in the map, m (default: 30)")
    parser.add_argument(
        "--lidar-at",
        type=finite,
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="m; the lidar's place on what the path is of (default: 0 0 0)",
    )
    parser.add_argument(
        "--map-in-world",
        type=finite,
        nargs=4,
        default=(0.0, 0.0, 0.0, 0.0),
        metavar=("X", "Y", "Z", "YAW"),
        help="m, m, m, rad",
    )
    parser.add_argument("--picture", type=Path, help="write views, sections and errors to this PNG")
    parser.set_defaults(figures_of=judge_volume)


def judge_volume(options: argparse.Namespace) -> dict:
    """Return the figures of a map, by the options; draw its picture.

    Raises:
        SlamError: a file cannot be used, or options do not fit.
    """
    idle = [name for name in OF_PATH if getattr(options, name) is not None]
    if options.path is None and idle:
        raise EvaluationError(f"--{idle[0].replace('_', '-')} needs --path, the poses of the lidar.")
    if options.lidar and (options.elevation or options.field_of_view):
        raise EvaluationError("--lidar tells the beams; leave out --elevation and --field-of-view.")
    # trimesh, Embree and scipy take a second to import
    from gridslam.evaluation.volume.judging import Asked, volume_metrics

    return volume_metrics(
        Asked(
            map_file=options.map,
            world_file=options.world,
            path_file=options.path,
            lidar=options.lidar,
            elevation_deg=(options.elevation[0], options.elevation[1]) if options.elevation else None,
            field_of_view_deg=options.field_of_view,
            range_m=options.range,
            lidar_at_m=options.lidar_at,
            map_in_world=tuple(options.map_in_world),
            picture=options.picture,
        )
    )
