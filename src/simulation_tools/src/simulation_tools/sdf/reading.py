"""What every reader of a description is given: where files are, and what becomes of a part that is bad."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Sequence

from simulation_tools.sdf.document import Node
from simulation_tools.sdf.elements import Model
from simulation_tools.sdf.safe_xml import SdfError

Include = Callable[[Node, bool], Model | None]
"""Follows an ``<include>`` inside a model that is static, or not; None for a light."""


_PLACE = re.compile(r"^.*?:\d+: ", re.DOTALL)
"""``PATH:LINE: `` before the sentence of an error."""
_SUFFIX = re.compile(r" \(Included by .*?:\d+\.\)$", re.DOTALL)


@dataclass
class Omissions:
    """The bad parts of one request. is_lenient: they are left out and noted, as Gazebo does; else refused."""

    is_lenient: bool
    _said: dict[str, list] = field(default_factory=dict)
    """Reason -> the first sentence with it, and how many there are."""

    def leave_out(self, node: Node, error: SdfError) -> None:
        """Note that an element is left out, or raise the error."""
        if not self.is_lenient:
            raise error
        node.passed_over()
        reason = _SUFFIX.sub("", _PLACE.sub("", str(error)))
        first = self._said.setdefault(reason, [f"{node.label} is left out: {error}", 0])
        first[1] += 1

    @property
    def sentences(self) -> list[str]:
        """A sentence for each reason, in the order of the files."""
        return [
            sentence if count == 1 else f"{sentence} The same counts for {count - 1} more."
            for sentence, count in self._said.values()
        ]


@dataclass(frozen=True)
class Reading:
    """One request. model_path: folders of models. include: follows an ``<include>``."""

    model_path: Sequence[Path]
    include: Include
    omissions: Omissions
