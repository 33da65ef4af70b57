"""The beams of a scan, and every particle's map of them, in tiles that particles share."""
