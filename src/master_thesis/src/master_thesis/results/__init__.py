"""What a run leaves behind: its folder, its figures of merit and its pictures."""
