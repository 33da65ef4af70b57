"""Single keys from the terminal, without waiting for Return."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty

from flight_basics.errors import FlightBasicsError


class TerminalError(FlightBasicsError):
    """There is no terminal to read keys from."""


class Terminal:
    """The terminal on standard input, key by key; `restore` undoes the changes."""

    def __init__(self) -> None:
        try:
            self._file = sys.stdin.fileno()
            self._before = termios.tcgetattr(self._file)
        except (OSError, ValueError, AttributeError, termios.error):
            raise TerminalError(
                "There is no keyboard here, because standard input is not a terminal; start it in a separate "
                "terminal, or with device:=joy."
            ) from None
        tty.setcbreak(self._file)

    def keys(self, timeout_s: float) -> str:
        """Return the keys pressed since the last call.

        Wait at most this long (wall time) for the first one.
        """
        if not select.select([self._file], [], [], timeout_s)[0]:
            return ""
        data = os.read(self._file, 64)
        if not data:
            raise TerminalError("The terminal was closed.")
        return data.decode("utf-8", "ignore")

    def restore(self) -> None:
        """Undo the changes to the terminal."""
        termios.tcsetattr(self._file, termios.TCSADRAIN, self._before)
