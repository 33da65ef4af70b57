"""numba's compiler for the kernels of this workspace, and where it keeps their machine code."""
