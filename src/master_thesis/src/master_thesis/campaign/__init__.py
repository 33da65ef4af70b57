"""Campaigns: many trials of the in-process closed loop, on all cores or on a cluster, judged together."""
