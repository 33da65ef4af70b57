"""Folders for files that live no longer than their process."""

from __future__ import annotations

import os
import tempfile


def scratch_folder(what: str) -> tempfile.TemporaryDirectory:
    """Make a folder in the temporary folder. It goes when it is cleaned up, and at the interpreter's exit.

    A node ends without that exit. So the name tells of which process the folder is, and `node_tools.ending`
    removes it by its name.

    what: the name begins with it.
    """
    prefix = f"{what}_of_process_{os.getpid()}_"
    return tempfile.TemporaryDirectory(prefix=prefix, ignore_cleanup_errors=True)
