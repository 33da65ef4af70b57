"""The command ``rosrun inspection_tools findings``: rust and cracks in a folder of photographs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from inspection_tools.errors import InspectionToolsError, ReportError, SurveyError
from inspection_tools.findings.candidates import candidates_in
from inspection_tools.findings.findings_file import (
    STATUSES,
    decide,
    read_findings,
    with_decisions,
    write_findings,
)
from inspection_tools.findings.merging import Finding, merged
from inspection_tools.findings.parameters import FindingParameters
from inspection_tools.findings.placing import MeshSurface, Placed
from inspection_tools.photographs.folder import PhotographError, photographs_in, read_camera, read_photograph
from inspection_tools.survey.surface.mesh_file import read_mesh


def main(arguments: list[str] | None = None) -> int:
    """Run the command. Return the exit code: 0, or 1 with one sentence on stderr."""
    parser = argparse.ArgumentParser(prog="findings", description="Find rust and cracks in photographs.")
    parser.add_argument("folder", type=Path, help="of photographs with their poses")
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
        before = read_findings(target) if target.exists() else []
        findings = with_decisions(before, find(given.folder, given.mesh, FindingParameters()))
        write_findings(target, findings)
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


def find(folder: Path, mesh: Path, parameters: FindingParameters) -> list[Finding]:
    """Return the findings in a folder of photographs. A photograph that is damaged is named and left out.

    Raises:
        SurveyError: the folder has no photograph, or the mesh cannot be read.
        PhotographError: the calibration cannot be read.
    """
    paths = photographs_in(folder)
    if not paths:
        raise SurveyError(f"{folder}: there is no photograph with a JSON beside it.")
    camera, surface = read_camera(folder / "calibration.yaml"), MeshSurface(read_mesh(mesh).triangles_m)
    placed: list[Placed] = []
    for path in paths:
        try:
            picture, record = read_photograph(path)
        except PhotographError as error:
            print(f"findings: left out: {error}", file=sys.stderr)
            continue
        found = candidates_in(picture, parameters)
        on_surface = [surface.place(each, camera, record, parameters, path.name) for each in found]
        placed += [each for each in on_surface if each is not None]
    return merged(placed, parameters.apart)
