"""What the drawn worlds look like."""

from flights.worlds.writer import Colour, Surroundings

BARK = Colour(0.55, 0.40, 0.27)
STEEL = Colour(0.45, 0.50, 0.56)
PLASTER = Colour(0.88, 0.86, 0.80)
CONCRETE = Colour(0.62, 0.62, 0.60)
RUBBER = Colour(0.12, 0.12, 0.13)
GRASS = Surroundings(Colour(0.80, 0.87, 0.72))
LINOLEUM = Surroundings(Colour(0.90, 0.89, 0.86))
CLEAR_M = 3.0
"""Nothing stands nearer to start or goal along the way; a thick trunk's middle is that far."""
