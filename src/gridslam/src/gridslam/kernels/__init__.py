"""Compiled inner loops on plain arrays.

numba's cache notices changes of a kernel's own file only, so no kernel calls one of another file.
"""
