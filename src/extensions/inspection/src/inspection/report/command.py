"""The command ``rosrun inspection inspection_report``: a surveyor's page of an inspection."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from flight_basics.errors import FlightBasicsError, SurveyError
from inspection.report.comparison import check_comparable
from inspection.report.content import judged, page_content
from inspection.report.grades import GradeRules
from inspection.report.page import libraries, render, write_page
from inspection.report.plan_page import write_plan_page
from inspection.report.sources import Inspection, read_inspection
from inspection.ship.ship import Ship
from inspection.ship.ship_file import read_ship
from inspection.survey.plan_file import read_plan
from inspection.survey.poses import PLAN_SUFFIXES
from inspection.survey.surface.mesh_file import Mesh, read_mesh
from inspection.survey.surface.reading import read_surface
from mesh_files import KINDS


def main(arguments: list[str] | None = None) -> int:
    """Run the command. Return the exit code: 0, or 1 with one sentence on stderr."""
    parser = argparse.ArgumentParser(
        prog="inspection_report",
        description="Write report.html of an inspection's folder, or plan.html of a plan before its flight.",
    )
    parser.add_argument("folder", type=Path, help="of an inspection, or of photographs; or a plan (YAML)")
    parser.add_argument("--mesh", type=Path, help=f"the surface: {KINDS}")
    parser.add_argument("--ship", type=Path, help="YAML file of frames, strakes and areas")
    parser.add_argument("--last", type=Path, help="folder of the last survey, to compare with")
    parser.add_argument("--thickness", type=Path, help="CSV file of thickness readings")
    parser.add_argument("--out", type=Path, help="default: report.html in the folder, or plan.html")
    given = parser.parse_args(arguments)
    is_plan = given.folder.suffix in PLAN_SUFFIXES
    out = given.out or (given.folder.with_suffix(".html") if is_plan else given.folder / "report.html")
    try:
        if is_plan:
            write_page_of_plan(given.folder, out, given.mesh, given.ship)
        else:
            read = write_report(given.folder, out, given.mesh, given.ship, given.last, given.thickness)
            for each in read.damaged:
                print(f"inspection_report: {each} The page says so, and does without it.", file=sys.stderr)
    except FlightBasicsError as error:
        print(f"inspection_report: {error}", file=sys.stderr)
        return 1
    if not is_plan and not libraries():
        print(
            "inspection_report: libjs-three is not installed, so the page has still pictures only.",
            file=sys.stderr,
        )
    print(f"written: {out} ({out.stat().st_size / 1e6:.1f} MB)")
    return 0


def write_report(
    folder: Path,
    out: Path,
    mesh: Path | None = None,
    ship: Path | None = None,
    last: Path | None = None,
    thickness: Path | None = None,
) -> Inspection:
    """Write the page of an inspection's folder, and return what was read.

    Raises:
        FlightBasicsError: one sentence: a file that was named cannot be used, or nothing is in the folder.
    """
    inspection, rules = read_inspection(folder), GradeRules()
    own = read_ship(ship) if ship else Ship()
    before = read_inspection(last) if last else None
    if before is not None:
        check_comparable(before, inspection)
    known = judged(inspection, own, _mesh(mesh, inspection), before, thickness, rules)
    content, view = page_content(inspection, own, known, rules, out)
    write_page(out, render(content, view))
    return inspection


def write_page_of_plan(path: Path, out: Path, mesh: Path | None, ship: Path | None) -> None:
    """Write the page of a plan before its flight. mesh: None: the one that it was made for.

    Raises:
        FlightBasicsError: one sentence: a file cannot be used.
    """
    plan = read_plan(path)
    surface = read_surface(mesh or Path(plan.source), plan.asked, plan.home_m)
    write_plan_page(out, plan, surface.patches, read_ship(ship) if ship else None)


def _mesh(named: Path | None, inspection: Inspection) -> Mesh | None:
    """Return the mesh that is named, or else the one that the coverage or the plan was made for."""
    if named is not None:
        return read_mesh(named)
    told = [
        inspection.coverage.surface if inspection.coverage else "",
        inspection.plan.source if inspection.plan else "",
    ]
    for path in (Path(each) for each in told if each):
        if path.is_file():
            try:
                return read_mesh(path)
            except SurveyError:
                continue
    return None
