"""The second look: what a search finds in the photographs is photographed from nearer in the same survey."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol, Sequence

from inspection_tools.inspection.inspection import Inspection
from inspection_tools.survey.views.candidates import View


class Answer(Protocol):
    """Nearer photographs, and a sentence."""

    @property
    def views(self) -> Sequence[View]:
        """In the order of their flight."""

    @property
    def says(self) -> str:
        """A sentence."""


class Search(Protocol):
    """Searches photographs elsewhere, and never blocks."""

    def add(self, photograph: Path) -> None:
        """Search a photograph, soon."""

    def ask(self) -> None:
        """All photographs have come."""

    @property
    def answer(self) -> Answer | None:
        """None: it has not come yet."""

    def close(self) -> None:
        """End the search."""


class SecondLook:
    """Gives photographs to a search, and adds the nearer ones that it asks for to the inspection, once.

    While it waits for the search, the UAV flies home and hovers there.

    Args:
        inspection: that is flown. search: of its photographs.
    """

    def __init__(self, inspection: Inspection, search: Search) -> None:
        self._inspection, self._search = inspection, search
        self._has_asked = False
        inspection.awaits = True

    def stored(self, photograph: Path) -> None:
        """Take a photograph that is stored."""
        if not self._has_asked:
            self._search.add(photograph)

    def look(self, waits: bool) -> str:
        """Ask the search, or take its answer, if it is time to. waits: for a picture of the camera.

        Return what the search says, once; empty: nothing new.
        """
        lead = self._inspection
        if not lead.awaits:
            return ""
        if not self._has_asked and lead.todo.next is None and not waits:
            self._has_asked = True
            self._search.ask()
        answer = self._search.answer
        if answer is None:
            return ""
        lead.look_again(answer.views)
        self._search.close()
        return answer.says

    def close(self) -> None:
        """End the search, if it goes on."""
        if self._inspection.awaits:
            self._inspection.awaits = False
            self._search.close()
