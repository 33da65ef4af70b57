"""Finds the response model that predicts a recorded flight best, and how far the flight strayed from it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np
import scipy  # loads signal and others at their first use; that takes half a second
from numpy.lib.stride_tricks import sliding_window_view

from cepa.identification.recording import STEP_S, IdentificationError, Piece, Recording, pieces_of
from cepa.identification.response import ResponseModel

SETTLING_S = 1.0
"""At the start of a piece the acceleration is not known; after this time it follows from the commands."""
START_EVERY_S = 0.2
HORIZONS_S = np.array([0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5])
JUMP_M_S, JUMP_WITHIN_S, JUMPS_MIN = 0.4, 0.25, 4
EXPLAINED_MIN = 0.5
MARGIN_M = 0.05
"""The least `margin` of CEPA: deviations within it need no bound of the error."""
COVERED = 0.99
"""Share of the instants whose whole deviations the stated error covers."""
ACCELERATION_OVER_S = 0.2

Parameters = tuple[float, float, float, float]
"""p, i, lag in s, delay in s."""


@dataclass(frozen=True, eq=False)
class Identification:
    """A model, and how well it predicts the flight that it was found from."""

    model: ResponseModel
    deviation_rms_m: np.ndarray
    """(HORIZONS_S.size,): of the position after each time, from a measured velocity."""
    deviation_max_m: np.ndarray
    """The same, the greatest."""
    error_max_m_s2: float
    """The error that covers every instant."""
    explained: float
    """Share of the velocity's change within 1 s that is predicted."""
    instants: int
    """Number of predictions."""
    climb_lag_s: float | None
    """Time constant of the vertical velocity; None without vertical commands."""
    pieces: Sequence[Piece]
    """What was used of the recording."""


def identify(recording: Recording) -> Identification:
    """Return the response model of a recorded flight.

    D is taken as zero, because only p, i and lag over (1 + d) show. The jerk's limit does not show in
    velocities, and stays the default. The model's error covers the deviations
    beyond MARGIN_M at COVERED of all instants, its greatest acceleration is the greatest that was flown.
    Raises IdentificationError, in one sentence, if the recording does not tell.
    """
    pieces = pieces_of(recording)
    _check_jumps(pieces)
    parameters = _fit(pieces)
    p, i, lag, delay = parameters
    deviations, velocity_errors, changes = _deviations(pieces, parameters)
    explained = 1.0 - float(np.sqrt(np.mean(velocity_errors**2) / np.mean(changes**2)))
    if explained < EXPLAINED_MIN:
        raise IdentificationError(
            f"The measured velocity does not follow the commands (a model explains {max(explained, 0.0):.0%} "
            "of its changes); check the topics and their frames."
        )
    model = ResponseModel(
        p=p,
        i=i,
        d=0.0,
        lag_s=lag,
        delay_s=delay,
        acceleration_max_m_s2=_greatest_acceleration(pieces),
        error_m_s2=1.0,
    )
    distances = np.hypot(*np.moveaxis(deviations, 2, 0))
    steps = np.round(HORIZONS_S / STEP_S).astype(int)
    beyond = np.maximum(distances - MARGIN_M, 0.0) / model.tube_m(STEP_S, int(steps[-1]))[steps]
    return Identification(
        replace(model, error_m_s2=float(np.quantile(beyond.max(axis=1), COVERED))),
        np.sqrt(np.mean(distances**2, axis=0)),
        distances.max(axis=0),
        float(beyond.max()),
        explained,
        len(distances),
        _climb_lag_s(pieces),
        pieces,
    )


def predicted_velocities(piece: Piece, model: ResponseModel) -> np.ndarray:
    """Return the velocities (n, 2) m/s of the model on a piece's commands, from its first velocity."""
    f, g = model.transition(STEP_S)
    state = np.zeros((2, 4))
    state[:, 1] = piece.velocities[0, :2]
    velocities = np.empty((len(piece.times_s), 2))
    for k, command in enumerate(_delayed(piece.commands[:, :2], model.delay_s)):
        velocities[k] = state[:, 1]
        state = state @ f.T + np.outer(command, g)
    return velocities


def _check_jumps(pieces: Sequence[Piece]) -> None:
    within = round(JUMP_WITHIN_S / STEP_S)
    jumps, greatest = 0, 0.0
    for piece in pieces:
        change = np.hypot(*(piece.commands[within:, :2] - piece.commands[:-within, :2]).T)
        jumping = change >= JUMP_M_S
        jumps += int(np.count_nonzero(jumping[1:] & ~jumping[:-1]))
        greatest = max(greatest, float(change.max()))
    if jumps < JUMPS_MIN:
        raise IdentificationError(
            f"The commanded velocity jumps {jumps} times by {JUMP_M_S:g} m/s or more (at most by "
            f"{greatest:.2f} m/s), but must do so {JUMPS_MIN} times; fly steps (--fly)."
        )


def _fit(pieces: Sequence[Piece]) -> Parameters:
    weights = 1.0 / (0.02 + 0.05 * HORIZONS_S)[:, None]

    def residuals(values: np.ndarray) -> np.ndarray:
        return (_deviations(pieces, tuple(values))[0] * weights).ravel()

    fit = scipy.optimize.least_squares(
        residuals,
        (1.5, 0.1, 0.1, 0.05),
        bounds=((0.2, 0.0, 0.01, 0.0), (20.0, 20.0, 2.0, 0.5)),
        x_scale=(1.0, 0.5, 0.1, 0.05),
        diff_step=1e-4,
    )
    p, i, lag, delay = (float(value) for value in fit.x)
    if min(p - 0.2, 20.0 - p, 2.0 - lag) < 1e-3:
        raise IdentificationError(
            f"The recording does not tell the response (p would be {p:.3g} and the lag {lag:.3g} s); "
            "check the topics and their frames."
        )
    return p, i, lag, delay


def _deviations(pieces: Sequence[Piece], parameters: Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return deviations of position (k, HORIZONS_S.size, 2) m, measured less predicted, from k instants.

    Also the deviations of velocity after 1 s, and the velocity's change within it, both (k, 2) m/s. A
    prediction starts with the measured velocity. Its acceleration follows from what was commanded and
    measured before.
    """
    steps = np.round(HORIZONS_S / STEP_S).astype(int)
    second = round(1.0 / STEP_S)
    powers, kernels = _responses(_model_of(parameters), int(steps[-1]))
    found = []
    for piece in pieces:
        velocity = piece.velocities[:, :2]
        commands = _delayed(piece.commands[:, :2], parameters[3])
        after = np.arange(
            round(SETTLING_S / STEP_S), len(velocity) - steps[-1], round(START_EVERY_S / STEP_S)
        )
        states = _states(commands, velocity, parameters)[after]
        way = scipy.integrate.cumulative_trapezoid(velocity, dx=STEP_S, axis=0, initial=0.0)
        following = sliding_window_view(commands, steps[-1], axis=0)[after]
        deviations = np.empty((after.size, steps.size, 2))
        for column, k in enumerate(steps):
            flown = following[:, :, :k] @ kernels[:k, 0][::-1]
            deviations[:, column] = way[after + k] - way[after] - states @ powers[k, 0] - flown
        flown = following[:, :, :second] @ kernels[:second, 1][::-1]
        errors = velocity[after + second] - states @ powers[second, 1] - flown
        found.append((deviations, errors, velocity[after + second] - velocity[after]))
    deviations, errors, changes = (np.concatenate(arrays) for arrays in zip(*found))
    return deviations, errors, changes


def _responses(model: ResponseModel, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the powers 0 to ``steps`` of the model's transition (steps + 1, 4, 4), and its kernels.

    A kernel's row k (steps, 4) is what a command of 1 m/s during one STEP_S adds to the state k steps later.
    """
    f, g = model.transition(STEP_S)
    powers = np.empty((steps + 1, 4, 4))
    powers[0] = np.eye(4)
    for k in range(steps):
        powers[k + 1] = f @ powers[k]
    return powers, powers[:-1] @ g


def _states(commands: np.ndarray, velocities: np.ndarray, parameters: Parameters) -> np.ndarray:
    """Return the model's states (n, 2, 4: 0, v, a, I) if its velocity had always been the measured one."""
    p, i, lag, _ = parameters
    error = commands - velocities
    integral = i * STEP_S * (np.cumsum(error, axis=0) - error)
    stays = np.exp(-STEP_S / lag)
    wanted = p * error + integral
    acceleration = scipy.signal.lfilter([0.0, 1.0 - stays], [1.0, -stays], wanted, axis=0)
    return np.stack((np.zeros_like(velocities), velocities, acceleration, integral), axis=2)


def _delayed(commands: np.ndarray, delay_s: float) -> np.ndarray:
    whole, part = divmod(delay_s / STEP_S, 1.0)
    index = np.arange(len(commands)) - int(whole)
    newer, older = (commands[np.maximum(index - late, 0)] for late in (0, 1))
    return (1.0 - part) * newer + part * older


def _model_of(parameters: Parameters) -> ResponseModel:
    p, i, lag, _ = parameters
    return ResponseModel(p=p, i=min(i, 0.99 * p / lag), d=0.0, lag_s=lag)


def _greatest_acceleration(pieces: Sequence[Piece]) -> float:
    over = round(ACCELERATION_OVER_S / STEP_S)
    changes = [np.hypot(*(p.velocities[over:, :2] - p.velocities[:-over, :2]).T).max() for p in pieces]
    return float(max(changes)) / ACCELERATION_OVER_S


def _climb_lag_s(pieces: Sequence[Piece]) -> float | None:
    commands = np.concatenate([piece.commands[:, 2] for piece in pieces])
    if np.std(commands) < 0.5 * JUMP_M_S:
        return None

    def residuals(lag: np.ndarray) -> np.ndarray:
        stays = np.exp(-STEP_S / lag[0])
        errors = []
        for piece in pieces:
            velocity = piece.velocities[:, 2]
            coefficients = [0.0, 1.0 - stays], [1.0, -stays]
            following, _ = scipy.signal.lfilter(*coefficients, piece.commands[:, 2], zi=velocity[:1])
            errors.append(velocity - following)
        return np.concatenate(errors)

    return float(scipy.optimize.least_squares(residuals, [0.3], bounds=(0.01, 5.0), diff_step=1e-4).x[0])
