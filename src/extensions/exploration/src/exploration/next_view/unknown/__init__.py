"""What stays unknown when an exploration ends, why, and behind which openings."""
