"""The errors of the rendered camera."""

from simulation_tools.errors import SimulationToolsError


class PhotographError(SimulationToolsError):
    """A photograph cannot be made: bad settings, or a file of defects that cannot be read."""
