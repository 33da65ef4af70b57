"""An inspection that is flown: its request, its coverage, its pictures and its summary."""
