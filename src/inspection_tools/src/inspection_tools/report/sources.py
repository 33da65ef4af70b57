"""Reads what an inspection left in its folder. What is missing is told in one sentence, and left out."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, TypeVar

from inspection_tools.errors import InspectionToolsError, ReportError
from inspection_tools.findings.findings_file import read_findings
from inspection_tools.findings.merging import Finding
from inspection_tools.photographs.folder import PhotographRecord, photographs_in, read_camera, read_record
from inspection_tools.survey.camera import SurveyCamera
from inspection_tools.survey.plan import SurveyPlan
from inspection_tools.survey.plan_file import read_plan
from inspection_tools.survey.surface_record import SurfaceRecord, read_surface_record

T = TypeVar("T")


@dataclass(frozen=True)
class Shot:
    """A photograph: its file, and the record beside it."""

    path: Path
    record: PhotographRecord


@dataclass(frozen=True)
class Inspection:
    """What a folder holds; None: it is not there, or cannot be used. remarks: what is missing.

    photographs: the folder of them. coverage, result: contents of the JSON files.
    """

    folder: Path
    photographs: Path
    shots: tuple[Shot, ...]
    camera: SurveyCamera | None
    findings: tuple[Finding, ...] | None
    surface: SurfaceRecord | None
    coverage: dict[str, Any] | None
    plan: SurveyPlan | None
    result: dict[str, Any] | None
    remarks: tuple[str, ...]


def read_inspection(folder: Path) -> Inspection:
    """Read an inspection's folder, or a plain folder of photographs.

    Raises:
        ReportError: there is no such folder, or neither photographs nor findings are in it.
    """
    if not folder.is_dir():
        raise ReportError(f"{folder}: there is no such folder.")
    photographs = folder / "photographs" if (folder / "photographs").is_dir() else folder
    remarks: list[str] = []

    def of(name: str, read: Callable[[Path], T], missing: str) -> T | None:
        places = [each / name for each in (folder, photographs) if (each / name).is_file()]
        if not places:
            if missing:
                remarks.append(missing)
            return None
        try:
            return read(places[0])
        except InspectionToolsError as error:
            remarks.append(str(error))
            return None

    shots = _shots(photographs, remarks)
    findings = of("findings.json", read_findings, "The photographs were not searched for rust and cracks.")
    if not shots and findings is None:
        raise ReportError(f"{folder}: there are neither photographs nor findings in it.")
    camera = of("calibration.yaml", read_camera, "") if shots else None
    coverage = of("coverage.json", _json, "It was not determined which surface the photographs show.")
    surface = None
    if coverage is not None:
        told = "The record of the surface is missing; the coverage must be determined again."
        surface = of("coverage.npz", read_surface_record, told)
    plan = of("plan.yaml", read_plan, "There is no survey plan.")
    result = of("result.json", _json, "There is no record of the flights.")
    return Inspection(
        folder,
        photographs,
        tuple(shots),
        camera,
        None if findings is None else tuple(findings),
        surface,
        coverage,
        plan,
        result,
        tuple(remarks),
    )


def _shots(folder: Path, remarks: list[str]) -> list[Shot]:
    shots, damaged = [], []
    for path in photographs_in(folder):
        try:
            shots.append(Shot(path, read_record(path.with_suffix(".json"))))
        except InspectionToolsError:
            damaged.append(path.name)
    if damaged:
        remarks.append(f"{len(damaged)} photographs have a damaged record, the first {damaged[0]}.")
    if not shots:
        remarks.append("There are no photographs with their positions.")
    return shots


def _json(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ReportError(f"{path} cannot be read ({error}).") from None
    if not isinstance(content, dict):
        raise ReportError(f"{path}: is no record of an inspection.")
    return content
