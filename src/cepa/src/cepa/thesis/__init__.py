"""CEPA as the thesis has it: the original and the improved algorithm, and their emergency avoidance."""
