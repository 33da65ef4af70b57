"""Compiled inner loops on plain arrays.

Kernels call kernels of other files here. When any of these files changes, all kernels are compiled anew: see
`stale_code`.
"""

from pathlib import Path

from gridslam.kernels.stale_code import discard_stale_code

discard_stale_code(Path(__file__).parent)
