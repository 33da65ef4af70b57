"""Folders for files that live no longer than their process."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path


def scratch_folder(what: str) -> tempfile.TemporaryDirectory:
    """Make a folder in the temporary folder. It goes when it is cleaned up, and at the interpreter's exit.

    A node ends without that exit. So the name tells of which process the folder is, and `node_tools.ending`
    removes it by its name. What a process left that was killed goes now.

    what: the name begins with it.
    """
    mark = f"{what}_of_process_"
    for folder in Path(tempfile.gettempdir()).glob(f"{mark}*_*"):
        number = folder.name.removeprefix(mark).partition("_")[0]
        if number.isdigit() and not _runs(int(number)):
            shutil.rmtree(folder, ignore_errors=True)
    return tempfile.TemporaryDirectory(prefix=f"{mark}{os.getpid()}_", ignore_cleanup_errors=True)


def _runs(pid: int) -> bool:
    """Return whether there is a process of this number, whoever owns it."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
