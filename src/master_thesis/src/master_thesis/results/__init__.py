"""What a run leaves behind: its folder, its numbers and its pictures."""
