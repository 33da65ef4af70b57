"""The exceptions of inspection_tools, exploration and inspection: one base class, to catch them all."""


class InspectionToolsError(Exception):
    """Base of every error that these packages raise; its message is one sentence for the user."""


class ParameterError(InspectionToolsError):
    """A parameter, or a combination of parameters, that makes no sense."""


class ScanError(InspectionToolsError):
    """A scan that cannot be used: its geometry, its length or its limits are wrong."""


class PoseError(InspectionToolsError):
    """A pose or a setpoint that cannot be used: not finite, or with no orientation."""


class ContradictionError(InspectionToolsError):
    """Two nodes say where to fly, and it is not known which of them is to be obeyed."""


class VelocityError(InspectionToolsError):
    """A velocity that cannot be used: not finite."""


class MissionError(InspectionToolsError):
    """A mission that cannot be flown: no waypoints, or one that makes no sense."""


class MapError(InspectionToolsError):
    """Voxels that cannot become a map: their number, size or kinds are wrong, or they are too far apart."""


class NoPathError(InspectionToolsError):
    """There is no safe path; the message says what blocks it."""


class SurveyError(InspectionToolsError):
    """A survey that cannot be planned, read or judged: its surface, its plan or its photographs are wrong."""


class ShipError(InspectionToolsError):
    """A ship's frames, strakes or areas that make no sense, or a file of them that cannot be read."""


class ReportError(InspectionToolsError):
    """A report that cannot be written, or findings, readings or records in its folder that cannot be read."""
