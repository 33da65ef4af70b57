"""Photographs of every square metre that a UAV can reach: which, in what order, and what they covered."""

from inspection_tools.camera.survey_camera import SurveyCamera, optical_axes
from inspection_tools.survey.parameters import FlightParameters, SurveyParameters

__all__ = ["FlightParameters", "SurveyCamera", "SurveyParameters", "optical_axes"]
