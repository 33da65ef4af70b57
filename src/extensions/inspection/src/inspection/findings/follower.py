"""A process that looks at photographs while the UAV flies; `background` starts it and talks to it.

If the plan is a draft, it first completes the plan, and answers with the photographs that this adds.

On standard input comes a line for each photograph, its path. When all have come, a JSON list comes: the
places (x, y, z) of those that could not be taken. Then standard output gets a line, a JSON with `views` (x,
y, z, yaw and tilt in rad, of more photographs), `says`, a sentence, and `is_last`. If it is not the last
answer, these photographs come, too, and then a list again.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Iterable, Iterator

import numpy as np

from flight_basics.errors import FlightBasicsError, SurveyError
from inspection.findings.background import SearchTargets
from inspection.findings.kinds import FINDING_KINDS
from inspection.findings.parameters import FindingParameters
from inspection.findings.search import PhotographSearch, plan_nearer
from inspection.photographs.listing import check_picture
from inspection.photographs.record import PhotographError, read_record
from inspection.survey.plan import SurveyPlan
from inspection.survey.plan_file import read_plan, write_plan
from inspection.survey.planner import completed
from inspection.survey.supplement import ROUNDS, Supplement
from inspection.survey.surface.mesh_file import reference_of
from inspection.survey.surface.reading import Surface, read_surface

NICE = 10
"""The search leaves the processor to what flies."""
PARENT_S = 0.5
"""Between two looks whether the process still has its parent."""
SEED = 1


class Follower:
    """Looks at the photographs of one plan.

    Args:
        plan_file: that is flown. closer_file: gets the plan of nearer photographs, if there is one. targets:
            see there.

    Raises:
        FlightBasicsError: the plan or its mesh cannot be read.
    """

    def __init__(self, plan_file: Path, closer_file: Path, targets: SearchTargets) -> None:
        self._plan, self._plan_file, self._closer_file = read_plan(plan_file), plan_file, closer_file
        self._surface: Surface = read_surface(Path(self._plan.source), self._plan.asked, self._plan.home_m)
        self._supplement = Supplement(self._plan, self._surface) if targets.open else None
        self._search: PhotographSearch | None = None
        self._what = f"the {reference_of(self._surface.mesh.names)}"
        if targets.cracks:
            self._search = PhotographSearch(self._surface.mesh, FindingParameters(), closer_file.parent)
        self._left_out, self._rounds, self._rng = 0, ROUNDS, np.random.default_rng(SEED)

    def add(self, photograph: Path) -> None:
        """Take a photograph. One that is damaged is left out."""
        try:
            check_picture(photograph)
            if self._supplement is not None:
                taken = read_record(photograph.with_suffix(".json")).pose
                self._supplement.add(replace(taken, path=photograph))
            if self._search is not None:
                self._search.add(photograph)
        except PhotographError:
            self._left_out += 1

    def complete(self) -> dict | None:
        """Write the whole plan over a draft. Return what to photograph, too; None: it was whole."""
        if self._plan.draft is None:
            return None
        settled = len(self._plan.views)
        try:
            self._plan = completed(self._plan, self._surface)
            write_plan(self._plan_file, self._plan)
        except SurveyError as error:
            return {"views": [], "says": str(error), "is_last": True}
        number, share = len(self._plan.views), 100.0 * self._plan.figures["share"]
        says = (
            f"The plan is complete: {number} photographs show {share:.1f} % of what can be shown of "
            f"{self._what}."
        )
        return {"views": _rows(self._plan)[settled:], "says": says, "is_last": False}

    def answer(self, not_taken_m: list[list[float]]) -> dict:
        """Return the next answer."""
        says = f"{self._left_out} photographs are damaged. " if self._left_out else ""
        if self._supplement is not None and self._rounds:
            self._rounds -= 1
            try:
                more = self._supplement.plan_more(not_taken_m, self._rng)
            except SurveyError as error:
                more, says = None, f"{says}{error} "
            if more is not None:
                before, share = (100.0 * more.figures[key] for key in ("share_before", "share"))
                says += (
                    f"The photographs show {before:.1f} % of what can be shown of {self._what}; "
                    f"{len(more.views)} more are planned, for {share:.1f} %."
                )
                return {"views": _rows(more), "says": says, "is_last": False}
        return {**self._nearer(says), "is_last": True}

    def _nearer(self, says: str) -> dict:
        if self._search is None:
            return {"views": [], "says": f"{says}No more photographs are needed."}
        found = self._search.findings()
        kinds = [each.kind for each in found]
        counted = [f"{kinds.count(kind.name)} {kind.plural}" for kind in FINDING_KINDS]
        says += f"{' and '.join(counted)} are found so far. "
        try:
            nearer = plan_nearer(self._plan, self._surface, found)
        except SurveyError as error:
            return {"views": [], "says": f"{says}{error}"}
        if nearer.closer is None:
            return {"views": [], "says": f"{says}No crack needs a closer look."}
        plan = nearer.closer.plan
        write_plan(self._closer_file, plan)
        hidden = f" {len(nearer.hidden)} cracks cannot be seen from nearer." if nearer.hidden else ""
        return {
            "views": _rows(plan),
            "says": f"{says}{len(plan.views)} closer photographs are planned.{hidden}",
        }


def _rows(plan: SurveyPlan) -> list[list[float]]:
    return [[*view.place_m, view.yaw_rad, view.tilt_rad] for view in plan.views]


def follow(
    plan_file: Path, closer_file: Path, targets: SearchTargets, lines: Iterable[str]
) -> Iterator[dict]:
    """Look at the photographs whose paths come. Yield an answer each time that one is asked for.

    Before, yield one that completes the plan, if it is a draft.

    Raises:
        FlightBasicsError: the plan or its mesh cannot be read.
    """
    follower = Follower(plan_file, closer_file, targets)
    if (rest := follower.complete()) is not None:
        yield rest
        if rest["is_last"]:
            return
    for line in lines:
        if line.startswith("["):
            answer = follower.answer(json.loads(line))
            yield answer
            if answer["is_last"]:
                return
        else:
            follower.add(Path(line.rstrip("\n")))


def _end_with(parent: int) -> None:
    """End this process when its parent has: a node that starts again has its own one, for the same plan."""
    while os.getppid() == parent:
        time.sleep(PARENT_S)
    os._exit(1)


def main() -> int:
    """Run the process: PLAN CLOSER WANTED PARENT, the number of who starts it. Return its exit code."""
    os.nice(NICE)
    threading.Thread(target=_end_with, args=(int(sys.argv[4]),), daemon=True).start()
    given = Path(sys.argv[1]), Path(sys.argv[2]), SearchTargets(*json.loads(sys.argv[3]))
    try:
        for answer in follow(*given, sys.stdin):
            print(json.dumps(answer), flush=True)
    except FlightBasicsError as error:
        print(json.dumps({"views": [], "says": str(error), "is_last": True}), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
