"""The package's exceptions. Each message is one sentence: what is wrong, where, and what to do."""


class MasterThesisError(Exception):
    """Base of this package's exceptions."""


class ScenarioError(MasterThesisError):
    """A scenario, algorithm, lidar, start or goal that does not exist or makes no sense."""


class ResultsError(MasterThesisError):
    """The results folder cannot be made or written."""


class FlightError(MasterThesisError):
    """A flight that cannot be flown or measured as requested."""


class GraphError(MasterThesisError):
    """A graph of nodes that could not be started or measured, or that does not run."""


class TrialsError(MasterThesisError):
    """A file of trials or a scheduler that cannot be used, or trials that failed."""


class CampaignError(MasterThesisError):
    """A campaign's file or folder that cannot be used."""
