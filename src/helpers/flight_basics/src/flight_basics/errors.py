"""What inspection_tools, exploration and inspection raise: one base class, to catch them all."""


class FlightBasicsError(Exception):
    """Base of every error that these packages raise; its message is one sentence for the user."""


def sentence_of(error: Exception) -> str:
    """Return what is wrong in one sentence, also of an error that nobody expected."""
    if isinstance(error, FlightBasicsError):
        return str(error)
    words = " ".join(str(error).split())
    return f"It failed with {type(error).__name__} ({words}), which nobody expected; see the node's log file."


class ParameterError(FlightBasicsError):
    """A parameter, or a combination of parameters, that makes no sense."""


class ScanError(FlightBasicsError):
    """A scan that cannot be used: its geometry, its length or its limits are wrong."""


class PoseError(FlightBasicsError):
    """A pose or a setpoint that cannot be used: not finite, or with no orientation."""


class ContradictionError(FlightBasicsError):
    """Two nodes say where to fly, and it is not known which of them is to be obeyed."""


class VelocityError(FlightBasicsError):
    """A velocity that cannot be used: not finite."""


class MissionError(FlightBasicsError):
    """A mission that cannot be flown: no waypoints, or one that makes no sense."""


class MapError(FlightBasicsError):
    """Voxels that cannot become a map: their number, size or kinds are wrong, or they are too far apart."""


class NoPathError(FlightBasicsError):
    """There is no safe path; the message says what blocks it."""


class SurveyError(FlightBasicsError):
    """A survey that cannot be planned, read or judged: its surface, its plan or its photographs are wrong."""


class ShipError(FlightBasicsError):
    """A ship's frames, strakes or areas that make no sense, or a file of them that cannot be read."""


class ReportError(FlightBasicsError):
    """A report that cannot be written, or findings, readings or records in its folder that cannot be read."""
