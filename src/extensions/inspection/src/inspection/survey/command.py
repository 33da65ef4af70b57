"""The command ``rosrun inspection survey_planner``: plans a survey, checks a plan, judges coverage."""

from __future__ import annotations

import argparse
import sys
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flight_basics.errors import FlightBasicsError, SurveyError
from mesh_files import KINDS

if TYPE_CHECKING:
    from inspection.survey.parameters import SurveyParameters

OF_ASKED = (
    "resolution", "incidence", "share", "patch", "voxel", "spacing", "radius", "margin", "comfort", "finer",
    "around",
)  # fmt: skip
OF_JUDGED = tuple(name for name in OF_ASKED if name != "finer")
"""What was photographed is judged by the resolution itself."""
OUTSIDE = (
    "the mesh is surveyed from outside: nothing that surfaces enclose is flown into; --around is 6 m then"
)
OF_FLYING = ("speed", "passing_speed", "settle", "mass", "battery", "electronics", "endurance")
OF_CAMERA = ("width", "height", "field_of_view", "tilt_min", "tilt_max", "exposure")


def main(arguments: list[str] | None = None) -> int:
    """Run the command. Return the exit code: 0, or 1 with one sentence on stderr."""
    given = _parser().parse_args(arguments)
    try:
        given.run(given)
    except FlightBasicsError as error:
        print(f"survey_planner: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("survey_planner: interrupted; the last plan that was written stays.", file=sys.stderr)
        return 130
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="survey_planner", description="Plan photographs of every surface that a UAV can reach."
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    plan = commands.add_parser("plan", help="plan the photographs and the flights")
    _add_surface(plan)
    plan.add_argument(
        "--out", type=Path, default=Path("plan.yaml"), help="file to write (default: plan.yaml)"
    )
    plan.add_argument("--picture", type=Path, help="draw the plan as PNG")
    plan.add_argument("--passing", action="store_true", help="shoot in passing and do not hover")
    plan.add_argument("--search", type=float, default=20.0, metavar="S", help="CPU time of the search (20)")
    plan.add_argument("--no-bound", action="store_true", help="do not compute the bound of the photographs")
    plan.add_argument("--seed", type=int, default=1)
    plan.add_argument("--planning", default="greedy", metavar="NAME", help="way to plan them (greedy)")
    plan.add_argument("--outside", action="store_true", help=OUTSIDE)
    for name in OF_ASKED + OF_FLYING + OF_CAMERA:
        plan.add_argument(_option(name), type=float, metavar=_unit(name), help=_help(name))
    plan.set_defaults(run=_plan)
    check = commands.add_parser("check", help="check a plan that was edited")
    check.add_argument("plan", type=Path)
    _add_surface(check)
    check.set_defaults(run=_check)
    coverage = commands.add_parser("coverage", help="judge what photographs show, from where they were taken")
    _add_surface(coverage)
    coverage.add_argument(
        "--poses", type=Path, required=True, help="folder of photographs, CSV of poses, or a plan"
    )
    coverage.add_argument("--out", type=Path, default=Path("coverage.json"))
    coverage.add_argument(
        "--drawing", type=Path, help="mesh or world of the same place, if --mesh is what a flight mapped"
    )
    coverage.add_argument("--outside", action="store_true", help=OUTSIDE)
    for name in OF_JUDGED + OF_CAMERA:
        coverage.add_argument(_option(name), type=float, metavar=_unit(name), help=_help(name))
    coverage.set_defaults(run=_coverage)
    return parser


def _add_surface(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--mesh", type=Path, help=KINDS)
    parser.add_argument("--home", type=float, nargs=3, metavar=("X", "Y", "Z"), help="place of take-off, m")


def _option(name: str) -> str:
    return "--" + name.replace("_", "-")


def _unit(name: str) -> str:
    return {"resolution": "MM", "incidence": "DEG", "share": "0..1", "speed": "M/S"}.get(name, "NUMBER")


def _help(name: str) -> str:
    from inspection.camera.survey_camera import SurveyCamera
    from inspection.survey.parameters import FlightParameters, SurveyParameters

    for kind in (SurveyParameters, FlightParameters, SurveyCamera):
        for each in fields(kind):
            if each.name == name == "spacing":
                return "default: the UAV's width"
            if each.name == name:
                return "default: that of a hover" if each.default is None else f"default: {each.default}"
    return ""


def _known(names: tuple[str, ...], given: argparse.Namespace) -> dict[str, Any]:
    return {name: getattr(given, name) for name in names if getattr(given, name) is not None}


def _parameters(kind: Any, names: tuple[str, ...], given: argparse.Namespace) -> Any:
    known = _known(names, given)
    for name in ("width", "height"):
        if name in known:
            known[name] = round(known[name])
    return kind(**known)


def _surface(given: argparse.Namespace, asked: Any) -> Any:
    """Return room, patches and rays of the file that is named."""
    from inspection.survey.surface.reading import read_surface

    if given.mesh is None:
        raise SurveyError("Give the surface: --mesh FILE, a mesh or an SDF world.")
    return read_surface(given.mesh, asked, given.home)


def _plan(given: argparse.Namespace) -> None:
    from inspection.camera.survey_camera import SurveyCamera
    from inspection.survey.parameters import FlightParameters, SurveyParameters
    from inspection.survey.plan_file import write_plan
    from inspection.survey.planner import SurveyPlanner

    asked = _parameters(SurveyParameters, OF_ASKED, given)
    asked = replace(asked, outside=given.outside, planning=given.planning)
    flying = replace(_parameters(FlightParameters, OF_FLYING, given), passing=given.passing)
    camera = _parameters(SurveyCamera, OF_CAMERA, given)
    if not given.out.parent.is_dir():
        raise SurveyError(f"{given.out} cannot be written: there is no folder {given.out.parent}.")
    print("reads the surface", flush=True)
    surface = _surface(given, asked)
    _tell_room(surface, given.home is not None, asked.outside)
    planner = SurveyPlanner(
        surface.room, surface.patches, surface.ranges_m, camera, asked, flying, str(given.mesh)
    )
    plan = None
    for progress in planner.improve(given.seed, given.search, not given.no_bound):
        plan = replace(progress.plan, figures={**progress.plan.figures, **surface.figures})
        write_plan(given.out, plan)
        print(f"{progress.cpu_s:6.1f} s CPU  {progress.stage}: {_summary(plan)}", flush=True)
    assert plan is not None
    _tell(plan)
    if given.picture:
        from inspection.survey.picture import draw_plan

        draw_plan(given.picture, plan, surface.patches)
    print(f"written: {given.out}")


def _tell_room(surface: Any, is_given: bool, outside: bool) -> None:
    """Say first in which room the UAV flies, and what else there is."""
    room = surface.room
    x, y, z = room.home_m
    how = "that surfaces enclose most; --home chooses another one"
    if is_given or outside:
        how = "of --home" if is_given else "outside"
    print(f"room: the one {how}. The UAV takes off at x {x:.1f}, y {y:.1f}, z {z:.1f} m")
    for number, each in enumerate(room.regions):
        name = "this room" if number == 0 else "another room"
        kind = "open to the outside" if each.is_open else "closed"
        print(
            f"  {name}: {kind}, {each.flyable_m3:.1f} m3 in which the UAV fits, "
            f"{each.sheltered_m3:.1f} m3 of it within walls"
        )
    sides_m2 = float(surface.patches.areas_m2.sum())
    print(f"  its walls: {sides_m2:.0f} m2; the whole mesh: {surface.mesh.area_m2:.0f} m2", flush=True)


def _summary(plan: Any) -> str:
    f = plan.figures
    if "photographs_lp_bound" in f:
        return f"at least {f['photographs_lp_bound']:.0f} photographs are needed"
    return (
        f"{f['photographs']:.0f} photographs show {100 * f['share']:.1f} % of {f['reachable_m2']:.0f} m2; "
        f"{_flights(plan)}, {sum(each.time_s for each in plan.flights) / 60:.1f} min"
    )


def _flights(plan: Any) -> str:
    return "1 flight" if len(plan.flights) == 1 else f"{len(plan.flights)} flights"


def _tell(plan: Any) -> None:
    from inspection.survey.surface.mesh_file import NOT_SURVEYED

    f = plan.figures
    print(
        f"surface: {f['share'] * f['reachable_m2']:.0f} m2 are to be seen, of {f['reachable_m2']:.0f} m2 "
        "within "
        f"reach and {f['mesh_m2']:.0f} m2 of the whole {plan.reference}, both sides of sheets"
    )
    if "photographs_lp_bound" in f:
        bound = f["photographs_lp_bound"]
        ratio = f["photographs"] / max(bound, 1e-9)
        print(f"photographs: {f['photographs']:.0f}, at least {bound:.1f} (LP bound): {ratio:.2f} times")
    print(
        f"tour: {f['tour_s']:.0f} s, {f['tour_m']:.0f} m, at least {f['tour_bound_s']:.0f} s (Held-Karp): "
        f"{f['tour_s'] / f['tour_bound_s']:.3f} times; nearest neighbour {f['tour_nearest_s']:.0f} s"
    )
    for name, share in plan.shares.items():
        if name == NOT_SURVEYED:
            continue
        print(f"  {name:24s} {100 * share:5.1f} %")
    reasons: dict[str, float] = {}
    for each in plan.leftovers:
        reasons[each.why] = reasons.get(each.why, 0.0) + each.area_m2
    for why, area in reasons.items():
        print(f"cannot be photographed: {area:.1f} m2 {why}")


def _judged_by(given: argparse.Namespace, is_plan: bool) -> SurveyParameters:
    """Return what the photographs must show. A plan says it itself, and its mesh and place of take-off."""
    from inspection.survey.parameters import SurveyParameters
    from inspection.survey.plan_file import read_plan

    asked = SurveyParameters()
    if is_plan:
        plan = read_plan(given.poses)
        asked = replace(plan.asked, finer=0.0)
        given.mesh = given.mesh or Path(plan.source)
        given.home = given.home or list(plan.home_m)
    if given.mesh is None:
        raise SurveyError("Give the surface: --mesh FILE, a mesh or an SDF world.")
    return replace(asked, **_known(OF_JUDGED, given), outside=given.outside or asked.outside)


def _check(given: argparse.Namespace) -> None:
    from inspection.survey.checking import check_plan
    from inspection.survey.plan_file import read_plan

    plan = read_plan(given.plan)
    given.mesh = given.mesh or Path(plan.source)
    given.home = given.home or list(plan.home_m)
    surface = _surface(given, plan.asked)
    check_plan(plan, surface.room)
    print(f"{given.plan}: {len(plan.views)} photographs in {_flights(plan)} can be flown.")


def _warn(sentence: str) -> None:
    print(f"survey_planner: {sentence}", file=sys.stderr)


def _coverage(given: argparse.Namespace) -> None:
    from input_schemas import read_without
    from inspection.camera.survey_camera import SurveyCamera
    from inspection.files.coverage_record import CoverageRecord
    from inspection.photographs.searched import countable
    from inspection.survey.coverage import OnDrawing, coverage_of_file, write_coverage
    from inspection.survey.poses import PLAN_SUFFIXES, photograph_poses_in, read_photograph_poses
    from inspection.survey.surface.mesh_file import NOT_SURVEYED

    asked = _judged_by(given, given.poses.suffix.lower() in PLAN_SUFFIXES and not given.poses.is_dir())
    camera = _parameters(SurveyCamera, OF_CAMERA, given)
    listing = countable(given.poses)
    listing.tell(_warn)
    if given.poses.is_dir():
        taken, camera = photograph_poses_in(given.poses, listing, camera)
    else:
        taken, camera = read_photograph_poses(given.poses, camera)
    coverage = coverage_of_file(given.mesh, taken, camera, asked, given.home)
    drawing = None
    if given.drawing is not None:
        drawn = coverage_of_file(given.drawing, taken, camera, asked, given.home)
        drawing = OnDrawing.beside(coverage, str(given.drawing), drawn)
    record = write_coverage(
        given.out, coverage, str(given.mesh), str(given.poses), taken, asked, listing.left_out, drawing
    )
    print(f"photographs that count: {len(taken)}")
    for sentence in read_without(given.out, "The record", CoverageRecord, SurveyError)[0].in_words:
        print(sentence.replace("m²", "m2"))
    print(
        f"{record['shown_m2']:.0f} of {record['surface_m2']:.0f} m2 of all in its room are shown. The whole "
        f"mesh: {record['mesh_m2']:.0f} m2, both sides of sheets"
    )
    print(
        f"a surface counts as shown if a pixel covers at most {asked.resolution:g} mm of it, at most "
        f"{asked.incidence:g} degrees off its normal"
    )
    for name, each in record["classes"].items():
        if each["share"] is not None and name != NOT_SURVEYED:
            print(f"  {name:24s} {100 * each['share']:5.1f} %")
    print(f"written: {given.out}")
