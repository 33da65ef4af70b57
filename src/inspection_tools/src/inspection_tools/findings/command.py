"""The command ``rosrun inspection_tools findings``: rust and cracks in a folder of photographs."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path

from inspection_tools.errors import InspectionToolsError, SurveyError
from inspection_tools.findings.candidates import candidates_in
from inspection_tools.findings.merging import Finding, merged
from inspection_tools.findings.parameters import FindingParameters
from inspection_tools.findings.placing import MeshSurface, Placed
from inspection_tools.photographs.folder import PhotographError, photographs_in, read_camera, read_photograph
from inspection_tools.survey.surface.mesh_file import read_mesh


def main(arguments: list[str] | None = None) -> int:
    """Run the command. Return the exit code: 0, or 1 with one sentence on stderr."""
    parser = argparse.ArgumentParser(prog="findings", description="Find rust and cracks in photographs.")
    parser.add_argument("folder", type=Path, help="of photographs with their poses")
    parser.add_argument("--mesh", type=Path, required=True, help="STL, OBJ, PLY or GLB, or an SDF world")
    parser.add_argument("--out", type=Path, help="default: findings.json in the folder")
    given = parser.parse_args(arguments)
    try:
        findings = find(given.folder, given.mesh, FindingParameters())
        target = given.out or given.folder / "findings.json"
        content = {"frame": "map", "findings": [asdict(each) for each in findings]}
        target.write_text(json.dumps(content, indent=1), encoding="utf-8")
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
