"""Functions of `geometry`, compiled, for kernels to call. They take tuples of floats, as there."""

from __future__ import annotations

from kernel_cache.compiler import njit
from simulation_tools import geometry

compiled = njit(cache=True)

rotate = compiled(geometry.rotate)
rotate_inverse = compiled(geometry.rotate_inverse)
cross = compiled(geometry.cross)
quaternion_multiply = compiled(geometry.quaternion_multiply)
quaternion_from_rpy = compiled(geometry.quaternion_from_rpy)
yaw_from_quaternion = compiled(geometry.yaw_from_quaternion)
