"""A flight to one goal: its request, and whether it comes nearer."""
