"""The package's exception base class; each module's own error derives from it."""

from __future__ import annotations


class SimulationToolsError(Exception):
    """Base of every error this package raises on purpose; its text is one clear sentence for the user."""
