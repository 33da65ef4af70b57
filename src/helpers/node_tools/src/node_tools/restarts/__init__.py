"""What a node knows after it died and was started again."""
