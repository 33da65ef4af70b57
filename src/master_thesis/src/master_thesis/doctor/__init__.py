"""Finds what is wrong with an installation, a running graph or a bag, and says what to do about it.

`snapshot` and `machine` hold what was seen, as plain values. Each other module judges one side of it. A check
is a function from a snapshot to findings, so that a test can make up every case.
"""
