"""Trials run in several processes and are kept: an interrupted run goes on, a failed trial is repeated."""
