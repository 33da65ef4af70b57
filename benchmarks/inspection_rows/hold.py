"""The hold that is inspected, and what is asked of its photographs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from flights.inspecting.request import COMFORT_M, FINER
from inspection.survey.parameters import SurveyParameters

WORLD = Path(__file__).resolve().parents[2] / "src/extensions/flights/worlds/hold_3d.world"
HOME_M = (-9.0, 5.0, 1.5)
ASKED = SurveyParameters(radius=0.35, margin=0.25)
FLYING = replace(ASKED, comfort=COMFORT_M, finer=FINER)
"""As inspection.launch plans: the bounds of row plan are those of all places."""
