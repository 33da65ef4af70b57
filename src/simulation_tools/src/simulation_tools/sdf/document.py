"""One XML file, read safely. The document remembers which of its elements were read.

A reader asks a `Node` for its children by tag. Afterwards `Document.unsupported` names every element that was
not read, in one sentence. So an element can be unsupported, but is never dropped silently.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Callable, Iterator, Sequence

from lxml import etree

from simulation_tools.bounds import MAX_MAGNITUDE, are_sane
from simulation_tools.geometry import Pose, Vector3
from simulation_tools.sdf.checks import Check
from simulation_tools.sdf.safe_xml import MAX_FILE_BYTES, SdfError, parse_xml

Converter = Callable[[etree._Element, str], tuple[etree._Element, Sequence[str]]]
"""Makes SDF of another language's root and the document's name; its sentences become notes."""
LINES_NAMED = 3  # of each unsupported element, because a forest may repeat it for every tree
LESS = ("plugin", "sensor", "material", "gui", "audio", "projector", "light")
"""Elements that do not change where things are. The warning names them last."""


class Document:
    """A parsed XML file. name: path (or origin) for messages; folder: its folder, None for bare text."""

    def __init__(self, text: bytes, name: str, folder: Path | None) -> None:
        self.name = name
        self.folder = folder
        self.version: tuple[int, ...] = (1, 6)  # of SDF, as the root element says
        self._notes: dict[str, None] = {}
        self._understood: set[etree._Element] = set()
        self._root = parse_xml(text, name)

    @classmethod
    def from_file(cls, path: Path) -> Document:
        """Read a file; raises SdfError when it is missing, too large or not XML."""
        try:
            if path.stat().st_size > MAX_FILE_BYTES:
                raise SdfError(f"{path}:1: The file is larger than {MAX_FILE_BYTES // 2**20} MB.")
            return cls(path.read_bytes(), str(path), path.resolve().parent)
        except OSError as error:
            raise SdfError(f"{path}:1: The file cannot be read: {error.strerror}.") from None

    def root(self, *tags: str) -> Node:
        """Return the root element, which must have one of these tags; the first is the usual one."""
        node = Node(self._root, self)
        if node.tag not in tags:
            raise node.error(f"The file must start with <{tags[0]}>, not <{node.tag}>")
        self._understood.add(self._root)
        return node

    def convert(self, tag: str, converter: Converter) -> None:
        """Put in the place of a root with this tag what a converter makes of it."""
        if self._root.tag == tag:
            self._root, notes = converter(self._root, self.name)
            for sentence in notes:
                self.note(sentence)

    def understand(self, element: etree._Element, whole: bool = False) -> None:
        """Note that this element was read (whole: and everything in it)."""
        self._understood.update(element.iter() if whole else (element,))

    def note(self, sentence: str) -> None:
        """Note what is done otherwise than the file says. The sentence says where."""
        self._notes[sentence] = None

    def unsupported(self) -> tuple[str, ...]:
        """Return what was noted, and one sentence that names every element that was not read.

        What changes where things are comes first.
        """
        lines: dict[str, list[int]] = {}
        for element in self._unread(self._root):
            lines.setdefault(_tag_path(element), []).append(element.sourceline)
        if not lines:
            return tuple(self._notes)
        weighty_first = sorted(lines.items(), key=lambda item: _is_less(item[0]))
        named = ", ".join(f"<{path}> ({_line_list(numbers)})" for path, numbers in weighty_first)
        return (*self._notes, f"{self.name}: Not supported and therefore without effect: {named}.")

    def _unread(self, parent: etree._Element) -> Iterator[etree._Element]:
        for element in parent:
            if element in self._understood:
                yield from self._unread(element)
            else:
                yield element


class Node:
    """An element of a document: typed access to its children, with errors that name file and line."""

    def __init__(self, element: etree._Element, document: Document) -> None:
        self._element = element
        self.document = document
        self.tag: str = element.tag
        self.line: int = element.sourceline or 1

    def error(self, sentence: str) -> SdfError:
        """Return an error at this element's place; the sentence comes without its full stop."""
        return SdfError(f"{self.document.name}:{self.line}: {sentence}.")

    def note(self, sentence: str) -> None:
        """Note what is done otherwise than this element says; the sentence comes without its full stop."""
        self.document.note(f"{self.document.name}:{self.line}: {sentence}.")

    @property
    def label(self) -> str:
        """Return the element's name for messages: ``<link name="base">``."""
        name = self._element.get("name")
        return f'<{self.tag} name="{name}">' if name else f"<{self.tag}>"

    @property
    def is_leaf(self) -> bool:
        """Whether the element has no children."""
        return not len(self._element)

    @property
    def is_empty(self) -> bool:
        """Whether the element holds nothing. Gazebo then takes the default."""
        return self.is_leaf and not (self._element.text or "").strip()

    # -- structure -------------------------------------------------------------------------------------------
    def children(self, *tags: str) -> list[Node]:
        """Return the children with any of these tags, in the file's order."""
        found = self.children_unmarked(*tags)
        for node in found:
            self.document.understand(node._element)
        return found

    def children_unmarked(self, *tags: str) -> list[Node]:
        """Return the children without marking them as understood.

        The caller marks them later with `understood`.
        """
        return [Node(element, self.document) for element in self._element if element.tag in tags]

    def understood(self) -> Node:
        """Mark this element as supported, and return it."""
        self.document.understand(self._element)
        return self

    def passed_over(self) -> None:
        """Note that this element is left out as a whole, and that somebody says so."""
        self.document.understand(self._element, whole=True)

    def child(self, tag: str) -> Node | None:
        """Return the first child with this tag, or None. As in Gazebo, a second one has no effect."""
        found = self.children_unmarked(tag)
        return found[0].understood() if found else None

    def required(self, tag: str) -> Node:
        """Return the first child with this tag. Its absence is an error."""
        node = self.child(tag)
        if node is None:
            raise self.error(f"{self.label} has no <{tag}>")
        return node

    def one_of(self, *tags: str) -> Node:
        """Return the only child among these tags."""
        found = self.children(*tags)
        if len(found) != 1:
            raise self.error(f"{self.label} needs exactly one of " + ", ".join(f"<{tag}>" for tag in tags))
        return found[0]

    def accept(self, *tags: str) -> None:
        """Accept children that have no meaning in this simulator (e.g. hints for drawing)."""
        for element in self._element:
            if element.tag in tags:
                self.document.understand(element, whole=True)

    def accept_value(self, tag: str, *values: str) -> None:
        """Accept a child with one of these values. The warning names any other value."""
        for node in self.children_unmarked(tag):
            if (node._element.text or "").strip().lower() in values:
                node.understood()

    def accept_empty(self, *tags: str) -> None:
        """Accept children without any text in them."""
        for node in self.children_unmarked(*tags):
            if not "".join(node._element.itertext()).strip():
                self.document.understand(node._element, whole=True)

    def flattened(self, understand: bool) -> dict[str, str]:
        """Return the text of every leaf below this element by its path; understand: mark all of them."""
        if understand:
            self.document.understand(self._element, whole=True)
        found: dict[str, str] = {}
        _flatten(self._element, "", found)
        return found

    # -- values ----------------------------------------------------------------------------------------------
    def attribute(self, name: str, default: str | None = None) -> str:
        """Return an attribute's text. Without a default the attribute must exist and not be empty."""
        value = self._element.get(name, default)
        if value is None or (default is None and not value.strip()):
            raise self.error(f'<{self.tag}> has no attribute "{name}"')
        return value.strip()

    def number_attribute(self, name: str, default: float, check: Check) -> float:
        """Return an attribute's number after a check."""
        text = self.attribute(name, str(default))
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and check.holds(value)):
            raise self.error(f'The attribute "{name}" must be {check.wanted}, not "{text[:60]}"')
        return value

    @property
    def text(self) -> str:
        """The element's own text, stripped. An empty text is an error."""
        text = (self._element.text or "").strip()
        if not text:
            raise self.error(f"<{self.tag}> is empty")
        return text

    def numbers(self, count: int) -> tuple[float, ...]:
        """Return the element's text as that many finite numbers.

        As in Gazebo, words behind them do not count; a note says so.
        """
        words = (self._element.text or "").split()
        if len(words) > count:
            beyond = " ".join(words[count:])[:60]
            self.note(f'What stands behind the numbers of <{self.tag}> does not count: "{beyond}"')
            words = words[:count]
        try:
            values = tuple(float(word) for word in words)
        except ValueError:
            values = ()
        if len(values) != count or not all(math.isfinite(value) for value in values):
            wanted = "a finite number" if count == 1 else f"{count} finite numbers"
            raise self.error(f'<{self.tag}> must hold {wanted}, not "{" ".join(words)[:60]}"')
        return values

    def value(self, tag: str, default: float, check: Check | None = None) -> float:
        """Return a child's number, or the default when there is no such child, or nothing in it."""
        node = self.child(tag)
        return default if node is None or node.is_empty else node.checked_number(check)

    def required_value(self, tag: str, check: Check | None = None) -> float:
        """Return a child's number; the child must be there."""
        return self.required(tag).checked_number(check)

    def limit(self, tag: str, default: float) -> float:
        """Return a child's number, which may be infinite (SDF writes 1e16 or inf for no limit)."""
        node = self.child(tag)
        if node is None:
            return default
        if node.text.lstrip("+-").lower() in ("inf", "infinity"):
            return -math.inf if node.text.startswith("-") else math.inf
        value = node.checked_number()
        return math.copysign(math.inf, value) if abs(value) >= 1e15 else value

    def vector(self, tag: str, default: Vector3) -> Vector3:
        """Return a child's three numbers, or the default."""
        node = self.child(tag)
        if node is None or node.is_empty:
            return default
        x, y, z = node.numbers(3)
        return x, y, z

    def flag(self, tag: str, default: bool) -> bool:
        """Return a child's truth value, or the default."""
        node = self.child(tag)
        if node is None or node.is_empty:
            return default
        if node.text.lower() not in ("true", "false", "1", "0"):
            raise node.error(f'<{tag}> must be true or false, not "{node.text[:60]}"')
        return node.text.lower() in ("true", "1")

    def checked_number(self, check: Check | None = None) -> float:
        """Return the element's own number after a check."""
        (value,) = self.numbers(1)
        if check is not None and not check.holds(value):
            raise self.error(f"<{self.tag}> must be {check.wanted}, not {value:g}")
        return value

    def pose(self) -> tuple[Pose, str]:
        """Return the child ``<pose>`` and the name of the frame it is given in ("" for the usual one)."""
        node = self.child("pose")
        if node is None:
            return Pose(), ""
        frame = node.attribute("relative_to", "") or node.attribute("frame", "")
        if not (node._element.text or "").strip():
            return Pose(), frame
        if node.attribute("rotation_format", "euler_rpy") == "quat_xyzw":  # from SDF 1.9 on
            return node._pose_of_quaternion(), frame
        numbers = node.numbers(6)
        if node.attribute("degrees", "false").lower() in ("true", "1"):
            numbers = (*numbers[:3], *map(math.radians, numbers[3:]))
        if not are_sane(numbers):
            raise node.error(f"<pose> must hold numbers up to {MAX_MAGNITUDE:g}")
        return Pose.from_xyz_rpy(*numbers), frame

    def _pose_of_quaternion(self) -> Pose:
        numbers = self.numbers(7)
        length = math.hypot(*numbers[3:])
        if not (are_sane(numbers) and length > 1e-6):
            raise self.error(f"<pose> must hold numbers up to {MAX_MAGNITUDE:g}, and a quaternion")
        x, y, z, *turn = numbers
        qx, qy, qz, qw = (value / length for value in turn)
        return Pose((x, y, z), (qx, qy, qz, qw))


def second_of_a_name(node: Node, first: Node) -> SdfError:
    """Return the error of an element whose name another one of its kind has already."""
    name = node.attribute("name")
    return node.error(f'A second <{node.tag}> is called "{name}"; the first is in line {first.line}')


def _flatten(element: etree._Element, path: str, found: dict[str, str]) -> None:
    for child in element:
        here = f"{path}{child.tag}"
        if len(child):
            _flatten(child, f"{here}/", found)
        else:
            found[here] = (child.text or "").strip()


def _tag_path(element: etree._Element) -> str:
    tags = [element.tag] + [ancestor.tag for ancestor in element.iterancestors()]
    return "/".join(str(tag) for tag in reversed(tags[:-1])) or str(element.tag)


def _is_less(tag_path: str) -> bool:
    return any(tag in LESS for tag in tag_path.split("/"))


def _line_list(numbers: list[int]) -> str:
    shown = ", ".join(str(number) for number in numbers[:LINES_NAMED])
    rest = len(numbers) - LINES_NAMED
    word = "line" if len(numbers) == 1 else "lines"
    return f"{word} {shown} and {rest} more" if rest > 0 else f"{word} {shown}"
