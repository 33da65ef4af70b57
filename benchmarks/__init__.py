"""The benchmarks of `./bringup.sh bench`: every module here whose name does not begin with an underscore.

Each is a script (`python -m benchmarks.NAME`) that prints tables and merges its numbers into
results/benchmarks.json.
"""
