"""The order of the photographs: ways in 3D, a short tour with its bound, and flights that fit the battery."""
