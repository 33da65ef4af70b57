"""The command ``rosrun inspection findings``: rust and cracks in a folder of photographs."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Sequence

from flight_basics.errors import FlightBasicsError, ReportError, SurveyError
from inspection.findings.findings_file import (
    STATUSES,
    SearchRecord,
    decide,
    held,
    read_findings,
    read_search,
    with_decisions,
    write_findings,
)
from inspection.findings.kinds import kinds_of
from inspection.findings.merging import SURE, Finding
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.flaws import counted
from inspection.findings.picture.paint import told_of_paint
from inspection.findings.search import plan_nearer, search_folders
from inspection.survey.plan import SurveyPlan
from inspection.survey.plan_file import read_plan, write_plan
from inspection.survey.surface.reading import Surface, read_surface
from mesh_files import KINDS


def main(arguments: list[str] | None = None) -> int:
    """Run the command. Return the exit code: 0, or 1 with one sentence on stderr."""
    parser = argparse.ArgumentParser(prog="findings", description="Find rust and cracks in photographs.")
    parser.add_argument("folder", type=Path, help="of photographs with their poses")
    parser.add_argument(
        "--closer", type=Path, nargs="+", default=[], metavar="FOLDER", help="of nearer photographs of cracks"
    )
    parser.add_argument(
        "--plan", type=Path, help="that was flown: write closer.yaml, a plan of nearer photographs of cracks"
    )
    parser.add_argument("--mesh", type=Path, help=f"{KINDS}. Needed for photographs with poses")
    parser.add_argument(
        "--coating", type=_colour, action="append", default=[], metavar="R,G,B",
        help="colour of a coating that is as red as rust, sRGB from 0 to 255; may be given several times",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, help="default: findings.json in the folder")
    parser.add_argument(
        "--decide", nargs=2, metavar=("NUMBER", "STATUS"),
        help="give a finding its status, and search no photographs: " + ", ".join(STATUSES),
    )  # fmt: skip
    parser.add_argument("--remark", help="the surveyor's, with --decide")
    given = parser.parse_args(arguments)
    target = given.out or given.folder / "findings.json"
    try:
        if given.decide:
            number, status = given.decide
            return _decide(target, number, status, given.remark)
        if not target.parent.is_dir():
            raise SurveyError(f"{target} cannot be written: there is no folder {target.parent}.")
        if target.exists():
            _check_before(target)
        parameters = FindingParameters(coatings=tuple(given.coating))
        plan = read_plan(given.plan) if given.plan else None
        if plan and given.mesh is None:
            raise SurveyError("--plan needs the surface: --mesh FILE, a mesh or an SDF world.")
        surface = read_surface(given.mesh, plan.asked, plan.home_m) if plan else None
        searched = surface.mesh if surface else given.mesh
        found = search_folders([given.folder, *given.closer], searched, parameters)
        record = _kept(target, found)
        findings = record.findings
        if plan and surface:
            print(_write_closer(plan, surface, findings, target.with_name("closer.yaml")))
    except FlightBasicsError as error:
        print(f"findings: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"findings: {error.filename} cannot be written: {error.strerror}.", file=sys.stderr)
        return 1
    for each in record.left_out:
        print(f"findings: left out: {each.name}: {each.why}", file=sys.stderr)
    for line in counted(record.flawed):
        print(f"findings: {line}", file=sys.stderr)
    for kind in kinds_of(each.kind for each in findings):
        print(f"{kind.name}: {sum(each.kind == kind.name for each in findings)}")
    unsure_m = [each.deviation_m for each in found.findings if each.deviation_m > parameters.apart]
    if unsure_m:
        print(
            f"findings: The places of {len(unsure_m)} findings may be wrong by {SURE * max(unsure_m):.1f} m "
            "(two standard deviations), by the poses of their photographs and the camera.",
            file=sys.stderr,
        )
    if record.red:
        print(f"findings: {told_of_paint(len(record.red), len(record.searched or ()))}", file=sys.stderr)
    if record.without_pose:
        print(f"findings: {_without_pose_in_words(record)}", file=sys.stderr)
    searched = len(record.searched or ())
    print(f"searched: {searched} of {searched + len(record.left_out)} photographs")
    print(f"written: {target}")
    return 0


def _without_pose_in_words(record: SearchRecord) -> str:
    marks = [mark.kind for each in record.without_pose for mark in each.marks]
    kinds = ", ".join(f"{kind}: {marks.count(kind)}" for kind in sorted(set(marks))) or "nothing"
    return (
        f"Photographs without a pose: {len(record.without_pose)}. They were searched on their own, and show "
        f"{kinds}; "
        "edges may look like cracks there. Run place_photographs and findings again for their places and "
        "sizes."
    )


def _colour(text: str) -> tuple[int, int, int]:
    """Return the colour in "R,G,B"; argparse names the option where ValueError is raised."""
    red, green, blue = (int(each) for each in text.split(","))
    return red, green, blue


def _check_before(path: Path) -> None:
    """Raise ReportError now, and not after minutes of search, if the findings of before are damaged."""
    try:
        read_search(path)
    except ReportError as error:
        hint = "Mend it, or move it away: the surveyor's decisions are in it."
        raise ReportError(f"{error} {hint}") from None


def _kept(path: Path, found: SearchRecord) -> SearchRecord:
    """Write what was found, with the decisions that stand in the file now; return it."""
    with held(path):
        before = read_findings(path) if path.exists() else []
        record = replace(found, findings=tuple(with_decisions(before, found.findings)))
        write_findings(path, record)
    return record


def _decide(path: Path, number: str, status: str, remark: str | None) -> int:
    if not (number.isascii() and number.isdigit()):
        raise ReportError(f'"{number}" is no number of a finding.')
    with held(path):
        record = read_search(path)
        findings = decide(record.findings, int(number), status, remark)
        write_findings(path, replace(record, findings=tuple(findings)))
    print(f"finding {number}: {status}")
    return 0


def _write_closer(plan: SurveyPlan, surface: Surface, findings: Sequence[Finding], target: Path) -> str:
    """Write a plan of nearer photographs, and return what it says of itself.

    Raises:
        SurveyError: a file cannot be used, or the UAV gets near none of the cracks.
    """
    nearer = plan_nearer(plan, surface, findings)
    if nearer.closer is None:
        return "No crack needs a closer look."
    flights = nearer.closer.plan.flights
    write_plan(target, nearer.closer.plan)
    hidden = "".join(f", not of finding {number}" for number in nearer.hidden)
    return (
        f"written: {target}, {len(nearer.closer.plan.views)} photographs in {len(flights)} flights, "
        f"{sum(each.time_s for each in flights) / 60.0:.1f} min{hidden}"
    )
