"""The package's exception base class; each module's own error derives from it."""

from __future__ import annotations


class SimulationToolsError(Exception):
    """Base of this package's errors. The text is one clear sentence for the user."""
