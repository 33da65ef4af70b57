"""The exceptions of this package; each message is one sentence for the user."""


class SlamError(Exception):
    """Base of everything that this package raises on purpose."""


class ParameterError(SlamError):
    """A parameter, or a combination of parameters, makes no sense."""


class ScanError(SlamError):
    """A laser scan that cannot be interpreted."""


class NoUsableBeamError(ScanError):
    """A scan in order of which no beam sees a wall."""


class MountingError(ScanError):
    """The lidar is mounted otherwise than TF tells, or the metre of odometry is another one."""


class MapError(SlamError):
    """A map that cannot be interpreted, or that has outgrown its bounds."""


class StateError(SlamError):
    """A saved state that cannot be read or does not fit."""


class PoseError(SlamError):
    """A pose on the map that cannot be used."""


class EvaluationError(SlamError):
    """A trajectory, a ground truth or a map that cannot be judged."""


def reason_of(error: Exception) -> str:
    """Return why a file cannot be used, without the path that an OSError repeats."""
    return str(getattr(error, "strerror", None) or error)
