"""A process that searches photographs while the UAV flies; `background` starts it and talks to it.

On standard input comes a line for each photograph, its path, and an empty line when all have come. Then
standard output gets one line, a JSON with `views` (x, y, z, yaw and tilt in rad, of nearer photographs) and
`says`, a sentence.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Iterable

from inspection_tools.errors import InspectionToolsError, SurveyError
from inspection_tools.findings.parameters import FindingParameters
from inspection_tools.findings.search import PhotographSearch, plan_nearer
from inspection_tools.photographs.folder import PhotographError
from inspection_tools.survey.plan_file import read_plan, write_plan
from inspection_tools.survey.surface.reading import read_surface

NICE = 10
"""The search leaves the processor to what flies."""


def follow(plan_file: Path, closer_file: Path, lines: Iterable[str]) -> dict | None:
    """Search the photographs whose paths come, until an empty line. Return the answer.

    None: nobody asked for it. closer_file: gets the plan of nearer photographs, if there is one. A
    photograph that is damaged is left out.

    Raises:
        InspectionToolsError: the plan or its mesh cannot be read.
    """
    plan = read_plan(plan_file)
    surface = read_surface(Path(plan.source), plan.asked, plan.home_m)
    search = PhotographSearch(surface.mesh, FindingParameters(), closer_file.parent)
    left_out = 0
    for line in lines:
        if not line.strip():
            break
        try:
            search.add(Path(line.rstrip("\n")))
        except PhotographError:
            left_out += 1
    else:
        return None
    found = search.findings()
    kinds = [each.kind for each in found]
    says = f"{kinds.count('rust')} rust spots and {kinds.count('crack')} cracks are found so far. "
    says += f"{left_out} photographs are damaged. " if left_out else ""
    try:
        nearer = plan_nearer(plan, surface, found)
    except SurveyError as error:
        return {"views": [], "says": f"{says}{error}"}
    if nearer.closer is None:
        return {"views": [], "says": f"{says}No crack needs a closer look."}
    write_plan(closer_file, nearer.closer.plan)
    views = [[*view.place_m, view.yaw_rad, view.tilt_rad] for view in nearer.closer.plan.views]
    hidden = f" {len(nearer.hidden)} cracks cannot be seen from nearer." if nearer.hidden else ""
    return {"views": views, "says": f"{says}{len(views)} closer photographs are planned.{hidden}"}


def main() -> int:
    """Run the process: PLAN CLOSER. Return its exit code."""
    os.nice(NICE)
    answer: dict | None
    try:
        answer = follow(Path(sys.argv[1]), Path(sys.argv[2]), sys.stdin)
    except InspectionToolsError as error:
        answer = {"views": [], "says": str(error)}
    if answer is not None:
        print(json.dumps(answer), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
