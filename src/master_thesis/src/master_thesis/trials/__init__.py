"""Trials: what is computed piece by piece, by some processes, and kept so that an interrupted run goes on."""
