"""A node's log file on a full disk: one sentence, in place of a traceback for each line that is lost."""

from __future__ import annotations

import logging
import sys

_usual = logging.Handler.handleError


def tell_once() -> None:
    """From now on tell once in this process that its log file cannot be written. The node works on."""
    told: list[str] = []

    def handle_error(handler: logging.Handler, record: logging.LogRecord) -> None:
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            _usual(handler, record)
        elif not told:
            told.append(getattr(handler, "baseFilename", "The log"))
            print(f"{told[0]} cannot be written: {error.strerror}. Free some space.", file=sys.stderr)

    logging.Handler.handleError = handle_error  # type: ignore[assignment, method-assign]
