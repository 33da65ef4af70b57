"""Shared by nodes that inspect: camera, photographs, detector, files of a survey, messages and markers."""
