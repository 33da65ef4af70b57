"""The exceptions of this package; each message is one sentence for the user."""


class CepaError(Exception):
    """Base of everything that this package raises on purpose."""


class ParameterError(CepaError):
    """A parameter, or a combination of parameters, makes no sense."""


class ScanError(CepaError):
    """A laser scan that cannot be interpreted."""


class VelocityError(CepaError):
    """A velocity that is not two finite numbers, or faster than anything flies."""


class AttitudeError(CepaError):
    """An attitude or a height of a lidar that makes no sense."""


class MotionError(CepaError):
    """A pose, a velocity or a cloud that makes no sense."""


class MountError(CepaError):
    """It is not known how a sensor sits on the body."""
