"""Reads mesh files of other programs as triangles in metres, z up."""
