"""What both nodes do alike: parameters, dynamic_reconfigure, warnings, a watch on the clock, start, end."""

from __future__ import annotations

import dataclasses
import math
import time

import rospy

from cepa import ALGORITHMS, CepaError, CepaParameters, ParameterError
from cepa_ros.ending import Ending, leave, silence_threads

WARNING_PERIOD_S = 5.0
LAST_CALLBACK_S = 0.4
HEARD_AFTER_S = 0.3  # wall time until whoever listens to /rosout is connected to a new node
RETRY_S, REMINDER_S = 1.0, 10.0  # wall time
FARTHEST_AHEAD_NS = 1_000_000_000
STANDS_STILL_S = 1.0  # of wall time, after which a clock that shows the same is taken for stopped


def parameters_of(config) -> tuple[str, CepaParameters]:
    """Return (algorithm's name, parameters) of a mapping that names them all, as dynamic_reconfigure's.

    Raises:
        ParameterError: a value makes no sense, alone or with the others.
    """
    algorithm = config["algorithm"]
    if algorithm not in ALGORITHMS:
        raise ParameterError(f"algorithm is {algorithm!r}; it must be one of {', '.join(ALGORITHMS)}.")
    values = {field.name: config[field.name] for field in dataclasses.fields(CepaParameters)}
    values["speed_fractions"] = _fractions(values["speed_fractions"])
    return algorithm, CepaParameters(**values)


def config_of(algorithm: str, parameters: CepaParameters) -> dict:
    """Return the mapping that ``parameters_of`` reads."""
    config = dataclasses.asdict(parameters)
    config["speed_fractions"] = " ".join(f"{fraction:g}" for fraction in parameters.speed_fractions)
    return {"algorithm": algorithm, **config}


def read_parameters() -> tuple[str, CepaParameters]:
    """Return (algorithm's name, parameters) from the private ROS parameters.

    They are written back as the types that they have, because dynamic_reconfigure does not convert them.

    Raises:
        ParameterError: as ``parameters_of``.
    """
    defaults = config_of("improved", CepaParameters())
    found = {name: rospy.get_param("~" + name, default) for name, default in defaults.items()}
    for name, value in found.items():
        if isinstance(defaults[name], float) and isinstance(value, int) and not isinstance(value, bool):
            found[name] = float(value)
    algorithm, parameters = parameters_of(found)
    for name, value in config_of(algorithm, parameters).items():
        rospy.set_param("~" + name, value)
    return algorithm, parameters


def serve_parameters(config_type, algorithm: str, parameters: CepaParameters, apply):
    """Offer the parameters in dynamic_reconfigure and call ``apply(algorithm, parameters)`` with each set.

    A set that makes no sense is refused with a warning, and the last one stays.
    """
    from dynamic_reconfigure.server import Server

    accepted = config_of(algorithm, parameters)

    def on_change(config, _level):
        try:
            changed = parameters_of(config)
        except ParameterError as error:
            rospy.logwarn("%s The change is refused; the old parameters stay.", error)
            config.update(accepted)
            return config
        accepted.update(config_of(*changed))
        config.update(accepted)
        apply(*changed)
        return config

    return Server(config_type, on_change)


def run(name: str, node_class, ending: Ending) -> None:
    """Run a node until it is told to end.

    What is wrong at the start is one sentence and exit code 1; or, with the parameter ~keep_trying, a
    sentence now and then, until it is mended.
    """
    ending.closes_by(lambda: rospy.signal_shutdown("signal"))
    try:
        rospy.init_node(name, disable_signals=True)
        node = _make_at_last(node_class) if rospy.get_param("~keep_trying", False) else node_class()
    except CepaError as error:
        _give_up(error)
    except Exception:
        if not rospy.core.is_shutdown_requested():
            raise
        leave(0, _answer_last_call)  # told to end while it was made
    # No callback may be under way when rospy closes the topics that it publishes on
    rospy.on_shutdown(lambda: node._lock.acquire(timeout=LAST_CALLBACK_S))
    rospy.on_shutdown(silence_threads)
    rospy.spin()
    leave(0, _answer_last_call)


def _make_at_last(node_class):
    """Return the node once nothing is wrong any more."""
    reminded_s = -math.inf
    while True:
        try:
            return node_class()
        except CepaError as error:
            rospy.rostime.wallsleep(RETRY_S)
            if rospy.is_shutdown():
                raise rospy.ROSInterruptException("told to end") from None
            if time.monotonic() - reminded_s > REMINDER_S:
                reminded_s = time.monotonic()
                _say_fatal(error)


def _say_fatal(error: CepaError) -> None:
    name = rospy.get_name()
    rospy.logfatal(
        "%s cannot start: %s Change it in the launch file, or by rosparam set under %s.", name, error, name
    )


def _give_up(error: CepaError) -> None:
    rospy.rostime.wallsleep(HEARD_AFTER_S)
    _say_fatal(error)
    leave(1, lambda: rospy.signal_shutdown("cannot start"))


def _answer_last_call() -> None:
    """Whoever told the node to end (rosnode kill) waits for an answer, which rospy gives now."""
    rospy.rostime.wallsleep(0.15)


class Warnings:
    """Says each fault once in a while, however often it comes and whatever numbers its sentence carries."""

    def __init__(self):
        self._said_at_s: dict[str, float] = {}

    def say(self, sentence) -> None:
        """Log the sentence as a warning unless its like was logged in the last seconds."""
        kind = "".join(character for character in str(sentence) if not character.isdigit())
        now_s = rospy.get_time()
        said_at_s = self._said_at_s.get(kind)
        if said_at_s is None or not 0.0 <= now_s - said_at_s < WARNING_PERIOD_S:
            self._said_at_s[kind] = now_s
            rospy.logwarn("%s", sentence)


class StampWatch:
    """Notices stamps of another clock than this node's, and that the clock jumped back."""

    def __init__(self, warnings: Warnings):
        self._warnings = warnings
        self._last_ns: int | None = None
        self._now: rospy.Time | None = None
        self._ran_at_s = -math.inf

    def is_ahead(self, stamp: rospy.Time, what: str) -> bool:
        """Whether a stamp lies far ahead of ROS time, which is warned of: its message is to be dropped.

        While ROS time is zero or stands still, as when a bag is played without --clock, no stamp is ahead.
        """
        now, wall_s = rospy.Time.now(), time.monotonic()
        if self._now is not None and now != self._now:
            self._ran_at_s = wall_s
        self._now = now
        ahead_ns = stamp.to_nsec() - now.to_nsec()
        if now.is_zero() or wall_s - self._ran_at_s > STANDS_STILL_S or ahead_ns <= FARTHEST_AHEAD_NS:
            return False
        self._warnings.say(
            f"The {what} is stamped {ahead_ns * 1e-9:.3f} s ahead of ROS time and dropped; "
            "is its sender on another clock?"
        )
        return True

    def went_back(self, stamp: rospy.Time) -> bool:
        """Take in the next message's stamp; warn and return True if it is older than the last one's."""
        stamp_ns = stamp.to_nsec()
        back_ns = 0 if self._last_ns is None else self._last_ns - stamp_ns
        self._last_ns = stamp_ns
        if back_ns > 0:
            self._warnings.say(f"The clock jumped back by {back_ns * 1e-9:.3f} s; starting anew.")
        return back_ns > 0


def _fractions(value) -> tuple[float, ...]:
    """Read "1.0 0.75", "1.0, 0.75", a number or a list."""
    if isinstance(value, str):
        value = value.replace(",", " ").split()
    elif isinstance(value, (int, float)):
        value = [value]
    try:
        return tuple(float(fraction) for fraction in value)
    except (TypeError, ValueError):
        raise ParameterError(
            f"speed_fractions must be numbers in (0, 1] such as '1.0 0.5', not {value!r}."
        ) from None
