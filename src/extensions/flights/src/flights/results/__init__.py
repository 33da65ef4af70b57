"""The results of a run: its folder, its numbers and its pictures."""
