"""Completes a draft: plans the flights that follow those that are settled."""

from __future__ import annotations

from inspection_tools.survey.plan import SurveyPlan
from inspection_tools.survey.planner import SurveyPlanner
from inspection_tools.survey.surface.reading import Surface


def completed(draft: SurveyPlan, surface: Surface) -> SurveyPlan:
    """Return the whole plan of a draft, which begins with its flights. A plan that is whole is returned.

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
