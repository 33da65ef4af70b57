"""Finds what is wrong with an installation, a running graph or a bag, and says what to do about it.

`snapshot` and `machine` describe what was seen in plain values; each other module judges one side of it. A
check is a function from a snapshot to findings, so that every case can be made up by hand.
"""
