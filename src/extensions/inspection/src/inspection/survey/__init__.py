"""Photographs of every square metre that a UAV can reach: which, in what order, and what they covered."""

from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.survey.parameters import FlightParameters, SurveyParameters

__all__ = ["FlightParameters", "SurveyCamera", "SurveyParameters", "optical_axes"]
