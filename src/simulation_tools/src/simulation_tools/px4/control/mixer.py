"""PX4's multirotor mixer: torques and thrust in, one command 0..1 per rotor out, desaturated.

If a rotor would leave 0..1, thrust is lowered first. Then roll and pitch are reduced. Yaw is mixed last and
reduced most. Thrust is never raised to help ("air mode" off). Structure as PX4's MultirotorMixer.
"""

from __future__ import annotations

from typing import Sequence

import numpy as np

from kernel_cache.compiler import njit

# PX4's rotor positions of a wide quadrotor, (x forward, y right) in metres, and the direction of turning:
# front right ccw, rear left ccw, front left cw, rear right cw. Airframe 10016 flies with this one.
QUAD_WIDE = (
    (0.1515, 0.245, 1.0),
    (-0.1515, -0.1875, 1.0),
    (0.1515, -0.245, -1.0),
    (-0.1515, 0.1875, -1.0),
)
MOMENT_PER_THRUST = 0.05
_LOW = 0.01  # a command below this counts as saturated


def mixing_matrix(rotors: Sequence[Sequence[float]]) -> np.ndarray:
    """Return (n, 4): commands per unit of roll, pitch, yaw torque and thrust.

    The pseudo-inverse of the effect of each rotor, scaled as PX4 does: roll and pitch alike, so that their
    largest column has the norm sqrt(n / 2); yaw so that its largest entry is 1; thrust so that the mean is 1.
    """
    effect = np.array([(-y, x, MOMENT_PER_THRUST * turn, 1.0) for x, y, turn in rotors]).T
    matrix = np.linalg.pinv(effect)
    scale = np.ones(4)
    scale[:2] = np.linalg.norm(matrix[:, :2], axis=0).max() / np.sqrt(len(rotors) / 2.0)
    scale[2] = np.abs(matrix[:, 2]).max()
    scale[3] = matrix[:, 3].mean()
    return matrix / scale


@njit(cache=True)
def _gain(direction: np.ndarray, outputs: np.ndarray, low: float, high: float) -> float:
    """Return the multiple of a direction that brings the outputs closest to the interval low..high."""
    least = 0.0
    most = 0.0
    for i in range(outputs.shape[0]):
        if abs(direction[i]) < 1e-7:
            continue
        if outputs[i] < low:
            k = (low - outputs[i]) / direction[i]
            least, most = min(least, k), max(most, k)
        if outputs[i] > high:
            k = (high - outputs[i]) / direction[i]
            least, most = min(least, k), max(most, k)
    return least + most


@njit(cache=True)
def _desaturate(
    direction: np.ndarray, outputs: np.ndarray, low: float, high: float, reduce_only: bool
) -> None:
    """Move the outputs along a direction into low..high. Share what does not fit between both ends."""
    gain = _gain(direction, outputs, low, high)
    if reduce_only and gain > 0.0:
        return
    for i in range(outputs.shape[0]):
        outputs[i] += gain * direction[i]
    gain = 0.5 * _gain(direction, outputs, low, high)
    for i in range(outputs.shape[0]):
        outputs[i] += gain * direction[i]


@njit(cache=True)
def mix(
    columns: np.ndarray,
    torques: np.ndarray,
    thrust: float,
    thrust_factor: float,
    outputs: np.ndarray,
    saturation: np.ndarray,
) -> None:
    """Fill outputs (n,) and saturation (3, 2). columns (4, n): the mixing matrix, transposed."""
    n = outputs.shape[0]
    for i in range(n):
        outputs[i] = torques[0] * columns[0, i] + torques[1] * columns[1, i] + thrust * columns[3, i]
    _desaturate(columns[3], outputs, 0.0, 1.0, True)
    _desaturate(columns[0], outputs, 0.0, 1.0, False)
    _desaturate(columns[1], outputs, 0.0, 1.0, False)
    for i in range(n):
        outputs[i] += torques[2] * columns[2, i]
    # Some yaw at full thrust is worth a little less thrust.
    _desaturate(columns[2], outputs, 0.0, 1.15, False)
    _desaturate(columns[3], outputs, 0.0, 1.0, True)

    for axis in range(3):
        saturation[axis, 0] = False
        saturation[axis, 1] = False
    for i in range(n):
        if outputs[i] < _LOW:
            # This rotor cannot go lower. Mark the direction of each axis for which this matters.
            for axis in range(3):
                if columns[axis, i] > 0.0:
                    saturation[axis, 0] = True
                elif columns[axis, i] < 0.0:
                    saturation[axis, 1] = True
        if thrust_factor > 0.0:
            # Thrust is factor u^2 + (1 - factor) u: invert it.
            wanted = max(outputs[i], 0.0)
            a = (1.0 - thrust_factor) / (2.0 * thrust_factor)
            outputs[i] = -a + (a * a + wanted / thrust_factor) ** 0.5
        outputs[i] = min(max(outputs[i], 0.0), 1.0)


class Mixer:
    """Mixes for one geometry.

    outputs: (n,) the newest commands. saturation: (3, 2) bool: axis, negative and positive direction.
    columns: (4, n) the mixing matrix, transposed.
    """

    def __init__(self, rotors: Sequence[Sequence[float]] = QUAD_WIDE) -> None:
        self.columns = np.ascontiguousarray(mixing_matrix(rotors).T)
        self.outputs = np.zeros(len(rotors))
        self.saturation = np.zeros((3, 2), dtype=np.bool_)

    def mix(self, torques: np.ndarray, thrust: float, thrust_factor: float = 0.0) -> np.ndarray:
        """Return the commands (n,), 0..1 (the same array each time). torques (3,) -1..1, thrust 0..1."""
        mix(self.columns, torques, thrust, thrust_factor, self.outputs, self.saturation)
        return self.outputs

    def stop(self) -> np.ndarray:
        """Return zero commands."""
        self.outputs[:] = 0.0
        self.saturation[:] = False
        return self.outputs
