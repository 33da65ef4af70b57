"""Logs of other programs: CARMEN."""
