"""The poses of one's own photographs: from EXIF, COLMAP, a table, or the bag of a flight."""
