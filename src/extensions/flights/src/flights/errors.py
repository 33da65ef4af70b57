"""The package's exceptions. Each message is one sentence: what is wrong, where, and what to do."""


class FlightsError(Exception):
    """Base of this package's exceptions."""


class ScenarioError(FlightsError):
    """A scenario, algorithm, lidar, start or goal that does not exist or makes no sense."""


class ResultsError(FlightsError):
    """The results folder cannot be made or written."""


class FlightError(FlightsError):
    """A flight that cannot be flown or measured as requested."""


class GraphError(FlightsError):
    """A graph of nodes that could not be started or measured, or that does not run."""


class TrialsError(FlightsError):
    """A file of trials or a scheduler that cannot be used, or trials that failed."""


class CampaignError(FlightsError):
    """A campaign's file or folder that cannot be used."""
