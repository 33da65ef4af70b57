"""What is kept from scan to scan beside maps: beams that stand out alone, mouths of dead ends."""
