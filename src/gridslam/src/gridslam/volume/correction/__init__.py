"""How a map follows its corrected path: what a correction begins from, and the new map beside the old."""
