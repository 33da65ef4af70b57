"""More photographs in the same survey: those that a draft lacks, of what stays open, and nearer ones."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Protocol, Sequence

from inspection.flight.inspection import Inspection
from inspection.survey.views.candidates import View


class Answer(Protocol):
    """More photographs, and a sentence."""

    @property
    def views(self) -> Sequence[View]:
        """In the order of their flight."""

    @property
    def says(self) -> str:
        """A sentence."""

    @property
    def is_last(self) -> bool:
        """Whether these are nearer ones, and no more follow. Else they show what the plan's did not."""


class Search(Protocol):
    """Searches photographs elsewhere, and never blocks."""

    def add(self, photograph: Path) -> None:
        """Search a photograph, soon."""

    def ask(self, left_out: Sequence[View]) -> None:
        """All photographs have come, but for these, which could not be taken."""

    def take_answer(self) -> Answer | None:
        """Return the answer, once; None: it has not come yet."""

    def close(self) -> None:
        """End the search."""


class SearchState(Enum):
    """What a search of photographs does. DONE: it has ended, and nothing is left to photograph."""

    IDLE = "idle"
    SEARCHING = "searching"
    DONE = "done"
    ABORTED = "aborted"


class SecondLook:
    """Gives photographs to a search, and adds to the inspection those that it asks for.

    While it waits for the search, the UAV flies home and hovers there. It lands if that takes long.

    Args:
        inspection: that is flown. search: of its photographs. is_draft: the inspection has the first flight
            of a plan; the search answers unasked with the others, once.
    """

    def __init__(self, inspection: Inspection, search: Search, is_draft: bool = False) -> None:
        self._inspection, self._search, self._lacks_rest = inspection, search, is_draft
        self._has_asked = self._is_aborted = self._is_closed = False
        inspection.awaits = True

    @property
    def state(self) -> SearchState:
        """SEARCHING: all photographs are taken, and the search has not answered yet."""
        if self._is_aborted:
            return SearchState.ABORTED
        lead = self._inspection
        is_awaited = self._has_asked or (self._lacks_rest and lead.queue.next is None)
        if lead.awaits:
            return SearchState.SEARCHING if is_awaited else SearchState.IDLE
        is_done = self._is_closed and lead.queue.next is None and not lead.lacks
        return SearchState.DONE if is_done else SearchState.IDLE

    @property
    def lacks_rest(self) -> bool:
        """Whether the photographs that a draft lacks have not been told yet."""
        return self._lacks_rest

    def abort(self) -> None:
        """Await no more photographs. The next `look` ends the search."""
        self._is_aborted, self._inspection.awaits = True, False

    def stored(self, photograph: Path) -> None:
        """Take a photograph that is stored."""
        if self._inspection.awaits:
            self._search.add(photograph)

    def look(self, waits: bool) -> str:
        """Ask the search, or take its answer, if it is time to. waits: for a picture of the camera.

        Return what the search says, once; empty: nothing new.
        """
        lead = self._inspection
        if not lead.awaits:
            self.close()
            return ""
        if not self._has_asked and not self._lacks_rest and lead.queue.next is None and not waits:
            self._has_asked = True
            self._search.ask(lead.queue.views_left_out)
        answer = self._search.take_answer()
        if answer is None:
            return ""
        if answer.is_last:
            if self._lacks_rest:
                lead.lacks = f"The plan is not complete. {answer.says}"
            lead.look_again(answer.views)
            self.close()
        else:
            lead.take_more(answer.views)
            self._has_asked = self._lacks_rest = False
        return answer.says

    def close(self) -> None:
        """End the search, if it goes on."""
        if not self._is_closed:
            self._is_closed, self._inspection.awaits = True, False
            self._search.close()
