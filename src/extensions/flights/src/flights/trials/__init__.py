"""Trials in several processes, with kept results: an interrupted run continues, a failed one is repeated."""
