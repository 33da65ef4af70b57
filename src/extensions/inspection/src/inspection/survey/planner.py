"""Plans a survey; a first plan comes early and gets better while time is left.

Or a first flight comes at once, and the others are planned while it is flown.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import Iterator, Sequence

import numpy as np

from flight_basics.errors import SurveyError
from inspection.camera.survey_camera import SurveyCamera
from inspection.survey.leftovers import leftovers_of
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import Draft, Flight, SurveyPlan
from inspection.survey.surface.patches import Patches
from inspection.survey.surface.reading import Surface
from inspection.survey.surface.room import Room
from inspection.survey.tour.flown import flown
from inspection.survey.views.candidates import Candidates, Ranges, View, lattice, near_home
from inspection.survey.views.cover import Cover
from inspection.survey.views.lp_bound import lp_bounds
from inspection.survey.views.planning import photograph_planning

FIRST_TRIES, LAST_TRIES = 0, 60
"""Perturbations of the tour. In hold_3d 60 shorten it by 0.4 % in 4 s of CPU time, 300 by 0.8 % in 15 s."""
COARSER = 2.0
"""The first plan's lattice is so many times as wide."""
NEAR_PLACES, SETTLED, EACH_M2 = 400, 60, 30.0
"""A draft visits some of so many places, nearest to home. It has so many photographs at most, and one for so
much of the surface. The others are found while these are flown: a hold's in a minute, a tank's sooner. With
60 in its draft, a tank needed 7 % more photographs."""


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
        self._photographs = photograph_planning(self._asked.planning)

    def first_flight(self, seed: int = 1, search_s: float = 20.0) -> SurveyPlan | None:
        """Return a draft: some photographs near home, soon; None: nothing can be photographed there.

        They are those that show most. What they leave open is for other flights, which `improve` finds, if
        these are settled.

        seed, search_s: for those. Raises: SurveyError: no photograph fits a battery.
        """
        near = self._candidates(self._patches, near_home(self._room, self._lattice(), NEAR_PLACES))
        if not len(near.seen):
            return None
        cover = Cover(near, self._asked)
        self._photographs.fill(cover, most=min(SETTLED, math.ceil(self._patches.areas_m2.sum() / EACH_M2)))
        if not cover.shots:
            return None
        flights, _ = flown(self._room, cover.views, self._flying, np.random.default_rng(seed), FIRST_TRIES)
        most = max(flights, key=lambda flight: len(flight.views))
        return replace(self._plan_of((most,), {}), draft=Draft(seed, search_s))

    def improve(
        self, seed: int = 1, search_s: float = 20.0, bound: bool = True, settled: Sequence[Flight] = ()
    ) -> Iterator[Progress]:
        """Yield flyable plans.

        The first tries few places, so less of the surface counts as reachable, and a later plan may need more
        photographs. From the second on all show the asked share of the same surface, and none costs more
        than the one before: has more photographs, or more where the UAV has little room.

        seed: of all that is drawn. search_s: CPU time of the local search. bound: compute the LP's bound.
        settled: flights whose photographs come first. Then there is no coarse plan, and no bound.

        Raises:
            SurveyError: nothing can be photographed, or not on one battery.
        """
        begin_s, rng = time.process_time(), np.random.default_rng(seed)

        def progress(stage: str, plan: SurveyPlan) -> Progress:
            return Progress(stage, time.process_time() - begin_s, plan)

        first = None if settled else self._coarse_plan(rng)
        if first is not None:
            yield progress("first plan", first)
        shown = self._shown_by(settled)
        candidates = self._candidates(self._patches.only(~shown), self._lattice())
        cover = Cover(candidates, self._asked, self._patches.only(shown).by_part_m2)
        self._photographs.fill(cover)
        if not cover.shots and settled:
            yield progress("all places", self._plan_of(tuple(settled), {"share": cover.share}))
            return
        if not cover.shots:
            raise SurveyError(
                f"Nothing can be photographed at {self._asked.resolution:g} mm per pixel: from where the UAV "
                "fits, every surface is too far, too oblique or hidden."
            )
        yield progress("all places", self._plan(candidates, cover, rng, FIRST_TRIES, settled))
        end_s = time.process_time() + search_s
        self._photographs.improve(cover, rng, lambda: time.process_time() < end_s)
        plan = self._plan(candidates, cover, rng, LAST_TRIES, settled)
        plan = replace(plan, leftovers=leftovers_of(self._room, candidates, self._asked, self._ranges_m))
        yield progress("local search", plan)
        if bound and not settled:
            for least in lp_bounds(candidates, cover, self._asked.share, rng):
                yield progress(
                    "bound", replace(plan, figures={**plan.figures, "photographs_lp_bound": least})
                )

    def _coarse_plan(self, rng: np.random.Generator) -> SurveyPlan | None:
        """Return a plan from few places; None: they show nothing."""
        coarse = self._candidates(self._patches, self._lattice(COARSER))
        if not len(coarse.seen):
            return None
        cover = Cover(coarse, self._asked)
        self._photographs.fill(cover)
        if not cover.shots:
            return None
        return self._plan(coarse, cover, rng, FIRST_TRIES)

    def _lattice(self, coarser: float = 1.0) -> np.ndarray:
        return lattice(self._room, coarser * self._asked.lattice_m)

    def _candidates(self, patches: Patches, places_m: np.ndarray) -> Candidates:
        speed_m_s = self._flying.shooting_speed
        found = Candidates(patches, places_m, self._camera, self._asked, self._ranges_m, speed_m_s)
        return found.comfortable(self._room)

    def _shown_by(self, flights: Sequence[Flight]) -> np.ndarray:
        """Return which patches (n,) photographs of flights draw."""
        shown = np.zeros(len(self._patches), bool)
        views = _views_of(flights)
        if not views:
            return shown
        places_m, speed_m_s = np.array([view.place_m for view in views]), self._flying.shooting_speed
        theirs = Candidates(
            self._patches, places_m, self._camera, self._asked, self._ranges_m, speed_m_s
        )  # fmt: skip
        for place, view in enumerate(views):
            shown[theirs.drawn(place, view.yaw_rad, view.tilt_rad)] = True
        return shown

    def _plan(
        self,
        candidates: Candidates,
        cover: Cover,
        rng: np.random.Generator,
        tries: int,
        settled: Sequence[Flight] = (),
    ) -> SurveyPlan:
        flights, figures = self._flown(cover.views, rng, tries, settled)
        areas = {
            "area_m2": float(self._patches.areas_m2.sum()),
            "reachable_m2": float(cover.by_class_m2.sum()),
            "share": cover.share,
        }
        there = cover.by_class_m2 > 0.0  # a thing of which nothing is within reach has no share
        names, told = np.array(candidates.patches.names)[there], cover.class_shares()[there]
        shares = dict(zip(names.tolist(), told.tolist()))
        return self._plan_of(flights, {**areas, **figures}, shares)

    def _flown(
        self, views: list[View], rng: np.random.Generator, tries: int, settled: Sequence[Flight]
    ) -> tuple[tuple[Flight, ...], dict[str, float]]:
        """Return flights and figures of the tour: what is settled first, then the views."""
        first = _views_of(settled)
        try:
            return flown(self._room, [*first, *views], self._flying, rng, tries, len(first))
        except SurveyError:
            if not settled:
                raise
        # One that is settled was edited to where no way leads: the others do not wait for it.
        flights, figures = flown(self._room, views, self._flying, rng, tries)
        return (*settled, *flights), figures

    def _plan_of(
        self, flights: tuple[Flight, ...], figures: dict[str, float], shares: dict[str, float] | None = None
    ) -> SurveyPlan:
        x, y, z = self._room.home_m.tolist()
        number = float(sum(len(flight.views) for flight in flights))
        return SurveyPlan(
            self._source, (x, y, z), self._camera, self._asked, self._flying, flights,
            {**figures, "photographs": number}, shares or {},
        )  # fmt: skip


def _views_of(flights: Sequence[Flight]) -> list[View]:
    return [each.view for flight in flights for each in flight.views]


def completed(draft: SurveyPlan, surface: Surface) -> SurveyPlan:
    """Return the whole plan of a draft, which begins with its photographs. A plan that is whole is returned.

    surface: of its mesh. Raises: SurveyError: a photograph is too far for a battery.
    """
    if draft.draft is None:
        return draft
    planner = SurveyPlanner(
        surface.room, surface.patches, surface.ranges_m, draft.camera, draft.asked, draft.flying, draft.source
    )
    how = draft.draft
    *_, whole = planner.improve(how.seed, how.search_s, bound=False, settled=draft.flights)
    return whole.plan
