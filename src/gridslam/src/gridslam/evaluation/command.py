"""The command ``rosrun gridslam gridslam_evaluate``: measures errors of trajectories and maps."""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gridslam.errors import EvaluationError, SlamError, reason_of
from gridslam.evaluation.argument_types import finite, positive
from gridslam.evaluation.map_error import map_error
from gridslam.evaluation.relations import read_relations, relation_errors
from gridslam.evaluation.trajectory_error import (
    ALIGNMENTS,
    in_gaps,
    trajectory_error,
    trajectory_error_in_space,
)
from gridslam.evaluation.volume.arguments import add_volume_arguments
from gridslam.evaluation.walls import read_walls
from gridslam.files.replacing import replace_file
from gridslam.files.tum import is_level, read_tum, read_tum_in_space


def main(arguments: list[str] | None = None) -> int:
    """Run the command. Return the exit code: 0, or 1 with one sentence on stderr."""
    options = _parser().parse_args(arguments)
    try:
        for output in (options.json, getattr(options, "picture", None)):
            _refuse_unwritable(output)
        figures = options.figures_of(options)
        if options.json:
            _write_json(options.json, figures)
    except SlamError as error:
        print(f"gridslam_evaluate: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        what = error.filename or "The result"
        print(f"gridslam_evaluate: {what}: cannot be written ({reason_of(error)}).", file=sys.stderr)
        return 1
    _print(figures)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="gridslam_evaluate",
        description="Judge trajectories (TUM form), maps (yaml + pgm) and maps of voxels (.bt, .ot).",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    relations = commands.add_parser(
        "relations", help="errors by hand-verified relative poses (Kuemmerle et al. 2009)"
    )
    relations.add_argument("trajectory", type=Path, help="trajectory to judge, TUM form")
    relations.add_argument("relations", type=Path, help="t1 t2 x y z roll pitch yaw a line, may be .gz")
    relations.add_argument(
        "--scans",
        type=Path,
        help="TUM file whose stamps are the scans', for the exact relations (default: the trajectory's own)",
    )
    relations.set_defaults(figures_of=_relations)

    ate = commands.add_parser("ate", help="ATE and RPE against a ground truth, through evo")
    ate.add_argument("trajectory", type=Path, help="trajectory to judge, TUM form")
    ate.add_argument("truth", type=Path, help="ground truth, TUM form")
    ate.add_argument(
        "--align", choices=ALIGNMENTS, default="none", help="align before comparing (default: none)"
    )
    ate.add_argument(
        "--rpe-distance",
        type=positive,
        default=1.0,
        metavar="M",
        help="length of path for the RPE, m (default: 1)",
    )
    ate.set_defaults(figures_of=_ate)

    maps = commands.add_parser("map", help="distance of a map's occupied cells from the true walls")
    maps.add_argument("map", type=Path, help="map to judge, map_server's yaml")
    maps.add_argument(
        "walls", type=Path, help="true walls: x1 y1 x2 y2 a line, or points on them: x y a line"
    )
    maps.add_argument(
        "--map-in-world",
        type=finite,
        nargs=3,
        default=(0.0, 0.0, 0.0),
        metavar=("X", "Y", "YAW"),
        help="m, m, rad",
    )
    maps.add_argument("--estimate", type=Path, help="estimated path to draw, TUM form")
    maps.add_argument("--truth", type=Path, help="true path to draw, TUM form")
    maps.add_argument("--picture", type=Path, help="write map, walls and paths to this PNG")
    maps.set_defaults(figures_of=_map)

    volume = commands.add_parser("volume", help="a map of voxels against a world's true surfaces")
    add_volume_arguments(volume)

    for command in (relations, ate, maps, volume):
        command.add_argument("--json", type=Path, help="also write the numbers to this file")
    return parser


def _refuse_unwritable(path: Path | None) -> None:
    """Check before the work that the result can be written."""
    if path is None:
        return
    if path.is_dir():
        reason = "it is a folder"
    elif not path.parent.is_dir():
        reason = f"there is no folder {path.parent}"
    elif not os.access(path if path.exists() else path.parent, os.W_OK):
        reason = "no permission"
    else:
        return
    raise EvaluationError(f"{path}: cannot be written ({reason}).")


def _relations(options: argparse.Namespace) -> dict:
    trajectory = read_tum(options.trajectory)
    relations = read_relations(options.relations)
    scan_stamps = read_tum(options.scans).stamps_s if options.scans else trajectory.stamps_s
    exact = relations.exact(scan_stamps)
    judged = exact.within(trajectory.stamps_s[0], trajectory.stamps_s[-1])
    return {
        "all": asdict(relation_errors(trajectory, relations)),
        "exact": asdict(relation_errors(trajectory, exact)) if len(judged) else {"relations": 0},
    }


def _ate(options: argparse.Namespace) -> dict:
    estimate, truth = (read_tum_in_space(path) for path in (options.trajectory, options.truth))
    how = (options.align, options.rpe_distance)
    if is_level(estimate):
        if not is_level(truth):
            print(
                f"gridslam_evaluate: {options.trajectory} is planar (all heights are 0, nothing leans). So "
                "height, roll and pitch do not count; x, y and yaw do.",
                file=sys.stderr,
            )
        error = trajectory_error(read_tum(options.trajectory), read_tum(options.truth), *how)
    else:
        error = trajectory_error_in_space(estimate, truth, *how)
    judged, missed = len(error.stamps_s), int(in_gaps(estimate[:, 0], truth[:, 0]).sum())
    if missed:
        print(
            f"gridslam_evaluate: {options.truth} has gaps, in which {missed} poses of {options.trajectory} "
            "lie. They do not count.",
            file=sys.stderr,
        )
    outside = len(estimate) - judged - missed
    return {"poses": judged, "poses_outside": outside, "poses_in_gaps": missed, **error.as_dict()}


def _map(options: argparse.Namespace) -> dict:
    from gridslam.files.map_file import read_map

    if (options.estimate or options.truth) and not options.picture:
        raise EvaluationError("--estimate and --truth are drawn in the picture only; name it by --picture.")
    grid, walls, pose = read_map(options.map), read_walls(options.walls), tuple(options.map_in_world)
    estimate, truth = (read_tum(path) if path else None for path in (options.estimate, options.truth))
    accuracy = map_error(grid, walls, pose)
    if options.picture:
        from gridslam.evaluation.map_picture import draw_map_error

        draw_map_error(options.picture, grid, walls, accuracy, pose, estimate, truth)
    return accuracy.as_dict()


def _write_json(path: Path, figures: dict) -> None:
    replace_file(path, json.dumps(_no_nan(figures), indent=2) + "\n")


def _no_nan(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _no_nan(each) for key, each in value.items()}
    return None if isinstance(value, float) and math.isnan(value) else value


def _print(figures: dict, indent: str = "") -> None:
    for name, value in figures.items():
        if isinstance(value, dict):
            print(f"{indent}{name}")
            _print(value, indent + "  ")
        else:
            print(
                f"{indent}{name:32s} {value:.4g}"
                if isinstance(value, float)
                else f"{indent}{name:32s} {value}"
            )
