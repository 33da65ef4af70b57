"""What a worker of a local cluster does before its first trial (dask's `preload`)."""

from __future__ import annotations

import signal


def dask_setup(worker) -> None:
    """Leave Ctrl-C to the campaign, and load what every trial needs."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    import master_thesis.campaign.trial  # noqa: F401
