"""What is remembered from scan to scan: points of obstacles, and beams that stand out alone."""
