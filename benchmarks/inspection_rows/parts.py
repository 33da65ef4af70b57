"""A part of a plan."""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

from inspection.survey.plan import SurveyPlan
from inspection.survey.views.candidates import View


def only(whole: SurveyPlan, views: Sequence[View]) -> SurveyPlan:
    """Return the plan with some of its photographs."""
    kept = set(views)
    flights = (replace(f, views=tuple(v for v in f.views if v.view in kept)) for f in whole.flights)
    return replace(whole, flights=tuple(flights))
