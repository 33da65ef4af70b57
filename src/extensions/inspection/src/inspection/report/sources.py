"""Reads what an inspection left in its folder. What is missing is told in one sentence, and left out."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Callable, Collection, Mapping, Sequence, TypeVar

from flight_basics.errors import FlightBasicsError, ReportError, SurveyError
from input_schemas import read_without
from inspection.camera.survey_camera import SurveyCamera
from inspection.files.coverage_record import CoverageRecord
from inspection.files.run_record import RunRecord
from inspection.findings.findings_file import SearchRecord, read_search
from inspection.findings.kinds import CRACK, RUST
from inspection.findings.merging import Finding
from inspection.findings.picture.flaws import BLURRED
from inspection.findings.picture.on_pictures import MarkedPicture
from inspection.findings.picture.paint import told_of_paint
from inspection.photographs.calibration import read_camera
from inspection.photographs.listing import LeftOut, listed
from inspection.photographs.record import PhotographRecord
from inspection.photographs.searched import changed_since
from inspection.report.words import counted
from inspection.survey.plan import SurveyPlan
from inspection.survey.plan_file import read_plan
from inspection.survey.surface_record import SurfaceRecord, read_surface_record

T = TypeVar("T")
NAMED = 3
"""Of photographs with the same fault, so many are named."""
AGAIN = {
    name: f"So there are no grades. Run {command} again."
    for name, command in (("findings", "findings"), ("coverage", "survey_planner coverage"))
}


@dataclass(frozen=True)
class Shot:
    """A photograph: its file, and the record beside it."""

    path: Path
    record: PhotographRecord


@dataclass(frozen=True)
class Inspection:
    """What a folder holds; None: it is not there, or cannot be used. remarks: what is missing.

    photographs: the folder of them. coverage, result: what the JSON files tell. unsearched: a sentence why
    the surface that photographs show does not count as seen, as nobody has looked for rust in all of them;
    empty: it counts. red: photographs whose coating is as red as rust. without_pose: photographs that were
    searched on their own, for their poses are not known. damaged: those remarks that name a file which is
    there, but cannot be used. blind: kinds of findings that most photographs cannot show: rust on a coating
    as red as rust, and cracks where they are blurred.
    """

    folder: Path
    photographs: Path
    shots: tuple[Shot, ...]
    camera: SurveyCamera | None
    findings: tuple[Finding, ...] | None
    surface: SurfaceRecord | None
    coverage: CoverageRecord | None
    plan: SurveyPlan | None
    result: RunRecord | None
    remarks: tuple[str, ...]
    unsearched: str = ""
    red: int = 0
    without_pose: tuple[MarkedPicture, ...] = ()
    damaged: tuple[str, ...] = ()
    blind: tuple[str, ...] = ()

    @property
    def seen(self) -> SurfaceRecord | None:
        """The surface with what photographs show that were searched; None: it is not known."""
        return None if self.unsearched else self.surface


def read_inspection(folder: Path) -> Inspection:
    """Read an inspection's folder, or a plain folder of photographs.

    Raises:
        ReportError: there is no such folder, or neither photographs nor findings are in it.
    """
    if not folder.is_dir():
        raise ReportError(f"{folder}: there is no such folder.")
    photographs = folder / "photographs" if (folder / "photographs").is_dir() else folder
    remarks: list[str] = []
    damaged: list[str] = []

    def of(name: str, read: Callable[[Path], T], missing: str) -> T | None:
        places = [each / name for each in (folder, photographs) if (each / name).is_file()]
        if not places:
            if missing:
                remarks.append(missing)
            return None
        try:
            return read(places[0])
        except FlightBasicsError as error:
            remarks.append(str(error))
            damaged.append(str(error))
            return None

    def without(schema: type[T]) -> Callable[[Path], T]:
        def read(path: Path) -> T:
            held, left_out = read_without(path, "The record", schema, ReportError)
            remarks.extend(left_out[:NAMED])
            if left_out[NAMED:]:
                remarks.append(f"{path}: {counted(len(left_out) - NAMED, 'more thing')} are left out.")
            return held

        return read

    search = of("findings.json", read_search, "The photographs were not searched for rust and cracks.")
    marked = () if search is None else search.without_pose
    shots = _shots(photographs, remarks, {each.photograph for each in marked})
    findings = None if search is None else search.findings
    if not shots and findings is None:
        raise ReportError(f"{folder}: there are neither photographs nor findings in it.")
    camera = of("calibration.yaml", read_camera, "") if shots else None
    coverage = of(
        "coverage.json", without(CoverageRecord), "It was not determined which surface the photographs show."
    )
    surface = None
    if coverage is not None:
        told = "The record of the surface is missing; the coverage must be determined again."
        surface = of("coverage.npz", partial(_surface, coverage), told)
    plan = of("plan.yaml", read_plan, "There is no survey plan.")
    result = of("result.json", without(RunRecord), "There is no record of the flights.")
    unsearched = ""
    if surface is not None and search is not None and coverage is not None:
        unsearched = (
            _unsearched(coverage, search)
            or _changed(photographs, search.rests_on, "findings")
            or _changed(photographs, coverage.rests_on, "coverage")
        )
    if unsearched:
        remarks.append(unsearched)
    for name, record in (("findings", search), ("coverage", coverage)):
        if record is not None and shots and not record.rests_on:
            remarks.append(f"{name}.json does not tell whether its photographs and poses were these.")
    if search is not None:
        remarks += _left_out("Not searched", [*search.left_out, *_newer(shots, search)])
        remarks += _left_out("Searched with a flaw", search.flawed)
        if search.red:
            told = told_of_paint(len(search.red), len(search.searched or ()))
            remarks.append(f"{told} Until then no coating is graded.")
    if camera and plan and (camera.width, camera.height) != (plan.camera.width, plan.camera.height):
        remarks.append(
            f"The photographs have {camera.width} x {camera.height} px, and the plan is of "
            f"{plan.camera.width} x {plan.camera.height} px: a pixel does not cover what was asked for."
        )
    return Inspection(
        folder,
        photographs,
        tuple(shots),
        camera,
        findings,
        surface,
        coverage,
        plan,
        result,
        tuple(remarks),
        unsearched,
        0 if search is None else len(search.red),
        () if search is None else search.without_pose,
        tuple(damaged),
        () if search is None else _blind(search),
    )


def _shots(folder: Path, remarks: list[str], marked: Collection[str]) -> list[Shot]:
    """Return the photographs with poses. marked: those that were searched without one are told elsewhere."""
    listing = listed(folder, pixels=False)
    remarks += _left_out("Left out", [each for each in listing.left_out if each.name not in marked])
    if not listing.whole:
        remarks.append("There are no photographs with their positions.")
    return [Shot(path, record) for path, record in listing.whole]


def _left_out(what: str, left_out: Sequence[LeftOut]) -> list[str]:
    """Return in words which photographs do not count, for each reason."""
    reasons: dict[str, list[str]] = {}
    for each in left_out:
        reasons.setdefault(each.why, []).append(each.name)
    told = []
    for why, names in reasons.items():
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        told.append(f"{what}: {counted(len(names), 'photograph')} ({', '.join(names[:NAMED])}{more}). {why}")
    return told


def _unsearched(coverage: CoverageRecord, search: SearchRecord) -> str:
    """Return why what the coverage tells as shown does not count as seen; empty: it does."""
    if search.searched is None:
        return f"findings.json does not tell which photographs were searched. {AGAIN['findings']}"
    if not coverage.counted:
        return f"coverage.json does not tell which photographs it counts. {AGAIN['coverage']}"
    missing = sorted(set(coverage.counted) - set(search.searched))
    if missing:
        return (
            f"The coverage counts {counted(len(missing), 'photograph')} that nobody has searched, the first "
            f"{missing[0]}. {AGAIN['coverage']}"
        )
    return ""


def _newer(shots: Sequence[Shot], search: SearchRecord) -> list[LeftOut]:
    """Return the photographs that were stored after the search."""
    if search.searched is None:
        return []
    told = {*search.searched, *(each.name for each in search.left_out)}
    return [
        LeftOut(each.path.name, "It is newer than findings.json. Run findings again.")
        for each in shots
        if each.path.name not in told
    ]


def _changed(photographs: Path, rests_on: Mapping[str, str], what: str) -> str:
    """Return why findings or coverage are not those of these photographs; empty: they are."""
    changed = changed_since(photographs, rests_on)
    if not changed:
        return ""
    return (
        f"{counted(len(changed), 'photograph')}, the first {changed[0]}, or their poses or calibration, are "
        f"not as {what} has read them. {AGAIN[what]}"
    )


def _blind(search: SearchRecord) -> tuple[str, ...]:
    """Return the kinds of findings that most of the searched photographs cannot show."""
    blurred = sum(each.why == BLURRED for each in search.flawed)
    hidden = {RUST.name: len(search.red), CRACK.name: blurred}
    return tuple(kind for kind, count in hidden.items() if 2 * count > len(search.searched or ()))


def _surface(coverage: CoverageRecord, path: Path) -> SurfaceRecord:
    """Return the record of the surface; raises SurveyError if it is damaged, or of another run."""
    record = read_surface_record(path)
    if coverage.record is not None and coverage.record != hashlib.sha256(path.read_bytes()).hexdigest():
        raise SurveyError(f"{path} is not of the same run as coverage.json. {AGAIN['coverage']}")
    return record
