"""Every number of `dynamic` that is no parameter: value, unit, source, and what a greater one does.

Each constant's docstring has the form ``unit: meaning. Source: where it is from. Greater: what that does.``
`doc/constants.md` shows them in one table, which `scripts/constants_page.py` writes. Sources:

chosen
    The author chose it. No measurement of this number alone is on record.
flown
    Flights showed that it is needed (`doc/results.md`).
measured
    It was measured, in the simulation or from recordings.
grid
    It is a size of a grid or a list: time and memory against resolution or reach.
"""
