"""What every reader of a description is given: where files are, and what becomes of a part that is bad."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Callable, Collection, Sequence, TypeVar

from simulation_tools.sdf.document import Node, second_of_a_name
from simulation_tools.sdf.elements import Model
from simulation_tools.sdf.safe_xml import SdfError

Part = TypeVar("Part")
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

    def read(self, node: Node, reader: Callable[[Node], Part], instead: Part) -> Part:
        """Return what a reader makes of an element, or ``instead`` if the element is bad and left out."""
        try:
            return reader(node)
        except SdfError as error:
            self.leave_out(node, error)
            return instead

    def leave_out(self, node: Node, error: SdfError, what: str = "") -> None:
        """Note that an element is left out, or raise the error. what: it is called so, not by its tag."""
        if not self.is_lenient:
            raise error
        node.passed_over()
        reason = _SUFFIX.sub("", _PLACE.sub("", str(error)))
        first = self._said.setdefault(reason, [f"{what or node.label} is left out: {error}", 0])
        first[1] += 1

    def unique(self, nodes: Sequence[Node]) -> dict[str, Node]:
        """Return elements by their names. One without a name, and the second one of a name, is left out."""
        by_name: dict[str, Node] = {}
        for node in nodes:
            name = self.read(node, _name, None)
            first = node if name is None else by_name.setdefault(name, node)
            if first is not node:
                self.leave_out(node, second_of_a_name(node, first))
        return by_name

    def numbered(self, nodes: Sequence[Node]) -> dict[str, Node]:
        """Return elements by their names. The second one of a name gets a number behind it."""
        by_name: dict[str, Node] = {}
        for node in nodes:
            by_name.setdefault(node.attribute("name"), node)
        for node in nodes:
            name = node.attribute("name")
            if by_name[name] is node:
                continue
            if not self.is_lenient:
                raise second_of_a_name(node, by_name[name])
            other = free_name(name, by_name)
            note_number(node, node.tag, name, other)
            by_name[other] = node
        return by_name

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


def _name(node: Node) -> str | None:
    return node.attribute("name")


def free_name(name: str, taken: Collection[str]) -> str:
    """Return a name that is not taken: the name itself, or with a number behind it."""
    if name not in taken:
        return name
    return next(free for number in count() if (free := f"{name}_{number}") not in taken)


def note_number(node: Node, kind: str, name: str, numbered: str) -> None:
    """Note that the second element of a name is called otherwise here; kind: of the elements."""
    node.note(f'Two {kind}s are called "{name}"; the second one is "{numbered}" here')
