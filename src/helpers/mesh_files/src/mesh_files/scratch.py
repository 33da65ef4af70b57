"""Folders for files that live no longer than their process."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path


def scratch_folder(what: str) -> tempfile.TemporaryDirectory:
    """Make a folder in the temporary folder. It goes when it is cleaned up, and at the interpreter's exit.

    A node ends without that exit. So the name tells of which process the folder is, and `node_tools.ending`
    removes it by its name. What a process left that was killed goes now. Containers may share a temporary
    folder, and number their processes alike: the name also tells in which of them the process runs.

    what: the name begins with it.
    """
    mark, here = f"{what}_of_process_", f"_in_{_process_namespace()}_"
    for folder in Path(tempfile.gettempdir()).glob(f"{mark}*{here}*"):
        number = folder.name.removeprefix(mark).partition(here)[0]
        if number.isdigit() and not _runs(int(number)):
            shutil.rmtree(folder, ignore_errors=True)
    return tempfile.TemporaryDirectory(prefix=f"{mark}{os.getpid()}{here}", ignore_cleanup_errors=True)


def _process_namespace() -> int:
    """Return the number of the namespace in which this process has its number; each container has its own."""
    try:
        return os.stat("/proc/self/ns/pid").st_ino
    except OSError:  # a container may hide it
        return 0


def _runs(pid: int) -> bool:
    """Return whether there is a process of this number, whoever owns it."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
