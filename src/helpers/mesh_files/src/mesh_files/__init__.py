"""Reads mesh files of other programs as triangles in metres, z up."""

KINDS = "STL, OBJ or PLY (m, z up), glTF or GLB (m, y up), DAE or 3MF (in their unit), or an SDF world"
"""For the help of commands: what `reading` and `worlds` take, and which axis points up."""
