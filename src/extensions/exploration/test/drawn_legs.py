"""Costs of legs that a test draws, leg by leg, for what asks for many at once."""

from functools import partial

import numpy as np

of_legs = partial(np.vectorize, signature="(k),(k)->()")
