"""Finds faults of an installation, a running graph or a bag, and says what to do.

`snapshot` and `machine` hold the observations as plain values. Each other module checks one aspect. A check
is a function from a snapshot to diagnoses, so a test can construct every case.
"""
