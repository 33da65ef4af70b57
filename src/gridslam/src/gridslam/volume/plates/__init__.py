"""Flat pieces of the surface, fitted to the points of kept clouds: truer than the faces of voxels."""

from gridslam.volume.plates.fitting import PlateParameters, Plates, SeenPoints, plates_of, points_of

__all__ = ["PlateParameters", "Plates", "SeenPoints", "plates_of", "points_of"]
