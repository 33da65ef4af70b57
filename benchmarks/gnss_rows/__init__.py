"""Rows of the benchmark `gnss_denied` beside its missions."""
