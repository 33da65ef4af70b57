"""A camera with a lamp in the dark: photographs of a world's surfaces by Embree and numba."""
