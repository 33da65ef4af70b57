"""Plans a survey; a first plan comes early and gets better while time is left."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Iterator

import numpy as np

from inspection_tools.errors import SurveyError
from inspection_tools.survey.camera import SurveyCamera
from inspection_tools.survey.leftovers import leftovers_of
from inspection_tools.survey.parameters import FlightParameters, SurveyParameters
from inspection_tools.survey.plan import SurveyPlan
from inspection_tools.survey.surface.patches import Patches
from inspection_tools.survey.surface.room import Room
from inspection_tools.survey.tour.flown import flown
from inspection_tools.survey.views.candidates import Candidates, Ranges, lattice
from inspection_tools.survey.views.cover import Cover
from inspection_tools.survey.views.lp_bound import lp_bound

FIRST_TRIES, LAST_TRIES = 0, 300
COARSER = 2.0
"""The first plan's lattice is so many times as wide."""


@dataclass(frozen=True)
class Progress:
    """A plan so far. stage: what was done last; cpu_s: CPU time of it all; plan: flyable."""

    stage: str
    cpu_s: float
    plan: SurveyPlan


class SurveyPlanner:
    """Plans photographs of a surface, and flights that take them.

    Args:
        room: where the UAV flies. patches: the surface. ranges_m: rays through what hides.
        camera, asked, flying: parameters. source: name of the surface's file.
    """

    def __init__(
        self,
        room: Room,
        patches: Patches,
        ranges_m: Ranges,
        camera: SurveyCamera | None = None,
        asked: SurveyParameters | None = None,
        flying: FlightParameters | None = None,
        source: str = "",
    ):
        self._room, self._patches, self._ranges_m = room, patches, ranges_m
        self._camera, self._asked = camera or SurveyCamera(), asked or SurveyParameters()
        self._flying, self._source = flying or FlightParameters(), source

    def improve(self, seed: int = 1, search_s: float = 20.0, bound: bool = True) -> Iterator[Progress]:
        """Yield flyable plans.

        The first tries few places, so less of the surface counts as reachable, and a later plan may need more
        photographs. From the second on all show the asked share of the same surface, and none costs more
        than the one before: has more photographs, or more where the UAV has little room.

        seed: of all that is drawn. search_s: CPU time of the local search. bound: compute the LP's bound.

        Raises:
            SurveyError: nothing can be photographed, or not on one battery.
        """
        begin_s, rng = time.process_time(), np.random.default_rng(seed)

        def told(stage: str, plan: SurveyPlan) -> Progress:
            return Progress(stage, time.process_time() - begin_s, plan)

        coarse = self._candidates(COARSER * self._asked.lattice_m)
        if len(coarse.seen):
            first = Cover(coarse, self._asked)
            first.fill()
            first.drop_idle()
            if first.shots:
                yield told("first plan", self._plan(coarse, first, rng, FIRST_TRIES))
        candidates = self._candidates(self._asked.lattice_m)
        cover = Cover(candidates, self._asked)
        cover.fill()
        if not cover.shots:
            raise SurveyError(
                f"Nothing can be photographed at {self._asked.resolution:g} mm per pixel: from where the UAV "
                "fits, every surface is too far, too oblique or hidden."
            )
        cover.drop_idle()
        yield told("all places", self._plan(candidates, cover, rng, FIRST_TRIES))
        end_s = time.process_time() + search_s
        cover.improve(rng, lambda: time.process_time() < end_s)
        plan = self._plan(candidates, cover, rng, LAST_TRIES)
        plan = replace(plan, leftovers=leftovers_of(self._room, candidates, self._asked, self._ranges_m))
        yield told("local search", plan)
        if bound:
            least = lp_bound(candidates, cover, self._asked.share, rng)
            yield told("bound", replace(plan, figures={**plan.figures, "photographs_lp_bound": least}))

    def _candidates(self, spacing_m: float) -> Candidates:
        places_m, speed_m_s = lattice(self._room, spacing_m), self._flying.shooting_speed
        found = Candidates(self._patches, places_m, self._camera, self._asked, self._ranges_m, speed_m_s)
        return found.comfortable(self._room)

    def _plan(self, candidates: Candidates, cover: Cover, rng: np.random.Generator, tries: int) -> SurveyPlan:
        flights, figures = flown(self._room, cover.views, self._flying, rng, tries)
        x, y, z = self._room.home_m.tolist()
        areas = {
            "area_m2": float(self._patches.areas_m2.sum()),
            "reachable_m2": float(cover.areas_m2.sum()),
            "share": cover.share,
        }
        return SurveyPlan(
            self._source, (x, y, z), self._camera, self._asked, self._flying, flights,
            {**areas, **figures}, _shares(cover, candidates),
        )  # fmt: skip


def _shares(cover: Cover, candidates: Candidates) -> dict[str, float]:
    return dict(zip(candidates.patches.names, cover.class_shares().tolist()))
