"""The command ``rosrun inspection_tools findings``: rust and cracks in a folder of photographs."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Sequence

import numpy as np

from inspection_tools.errors import InspectionToolsError, ReportError, SurveyError
from inspection_tools.findings.candidates import candidates_in
from inspection_tools.findings.findings_file import (
    DISMISSED,
    STATUSES,
    decide,
    read_findings,
    with_decisions,
    write_findings,
)
from inspection_tools.findings.merging import Finding, merged
from inspection_tools.findings.parameters import FindingParameters
from inspection_tools.findings.placing import MeshSurface, Placed, PosedPhotograph
from inspection_tools.findings.second_look import without_refuted
from inspection_tools.photographs.folder import PhotographError, photographs_in, read_camera, read_photograph
from inspection_tools.survey.closer import closer_plan
from inspection_tools.survey.plan_file import read_plan, write_plan
from inspection_tools.survey.surface.mesh_file import read_mesh
from inspection_tools.survey.surface.reading import read_surface

CLOSER_MM, CLOSER_SEED = 0.3, 1
"""Of the surface per pixel of a nearer photograph. Cracks that are shown half as fine need none."""


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
    parser.add_argument("--mesh", type=Path, help="STL, OBJ, PLY or GLB, or an SDF world")
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
        if given.mesh is None:
            raise SurveyError("Give the surface: --mesh FILE, a mesh or an SDF world.")
        if not target.parent.is_dir():
            raise SurveyError(f"{target} cannot be written: there is no folder {target.parent}.")
        before = read_findings(target) if target.exists() else []
        findings = with_decisions(
            before, find([given.folder, *given.closer], given.mesh, FindingParameters())
        )
        write_findings(target, findings)
        if given.plan:
            print(_write_closer(given.plan, given.mesh, findings, target.with_name("closer.yaml")))
    except InspectionToolsError as error:
        print(f"findings: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"findings: {error.filename} cannot be written: {error.strerror}.", file=sys.stderr)
        return 1
    for kind in ("rust", "crack"):
        print(f"{kind}: {sum(each.kind == kind for each in findings)}")
    print(f"written: {target}")
    return 0


def _decide(path: Path, number: str, status: str, remark: str | None) -> int:
    if not number.isdigit():
        raise ReportError(f'"{number}" is no number of a finding.')
    write_findings(path, decide(read_findings(path), int(number), status, remark))
    print(f"finding {number}: {status}")
    return 0


def _write_closer(first: Path, mesh: Path, findings: Sequence[Finding], target: Path) -> str:
    """Write a plan of nearer photographs, and return what it says of itself.

    Raises:
        SurveyError: a file cannot be used, or the UAV gets near none of the cracks.
    """
    coarse = 2.0 * CLOSER_MM
    open_ = [e for e in findings if e.kind == "crack" and e.status != DISMISSED and not e.detail_mm <= coarse]
    if not open_:
        return "No crack needs a closer look."
    plan = read_plan(first)
    surface = read_surface(mesh, plan.asked, plan.home_m)
    closer = closer_plan(
        plan, open_, surface.room, surface.ranges_m, CLOSER_MM, np.random.default_rng(CLOSER_SEED)
    )
    write_plan(target, closer.plan)
    hidden = "".join(f", not of finding {open_[k].id}" for k in closer.hidden)
    time_s = sum(each.time_s for each in closer.plan.flights)
    return (
        f"written: {target}, {len(closer.plan.views)} photographs in {len(closer.plan.flights)} flights, "
        f"{time_s / 60.0:.1f} min{hidden}"
    )


def find(folders: Sequence[Path], mesh: Path, parameters: FindingParameters) -> list[Finding]:
    """Return the findings in folders of photographs. A photograph that is damaged is named and left out.

    Photographs of other folders than the first are named by their way from there.

    Raises:
        SurveyError: a folder has no photograph, or the mesh cannot be read.
        PhotographError: the calibration cannot be read.
    """
    surface: MeshSurface | None = None
    placed: list[Placed] = []
    near: list[PosedPhotograph] = []
    for folder in folders:
        paths = photographs_in(folder)
        if not paths:
            raise SurveyError(f"{folder}: there is no photograph with a JSON beside it.")
        camera = read_camera(folder / "calibration.yaml")
        surface = surface or MeshSurface(read_mesh(mesh).triangles_m)
        for path in paths:
            try:
                picture, record = read_photograph(path)
            except PhotographError as error:
                print(f"findings: left out: {error}", file=sys.stderr)
                continue
            name = os.path.relpath(path, folders[0])
            posed = PosedPhotograph(surface, camera, record, parameters, name)
            if posed.sight.finest_mm <= parameters.crack_closer:
                near.append(posed)
            sight = posed.sight
            found = candidates_in(picture, parameters, sight.judged, sight.detail_mm)
            on_surface = [posed.place(each) for each in found]
            placed += [each for each in on_surface if each is not None]
    return merged(without_refuted(placed, near, parameters), parameters.apart)
