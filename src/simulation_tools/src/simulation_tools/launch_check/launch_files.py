"""Reads a roslaunch file's arguments and nodes, because roslaunch ignores unknown arguments.

Conditions (if, unless) are ignored, so a file may start fewer nodes than listed.
"""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Iterable, Mapping
from xml.etree import ElementTree

from simulation_tools.errors import SimulationToolsError

BOOLEANS = ("true", "false")
OWN_CHECK = "flight_check"
"""A parameter of a launch file that is the output of a check. That check includes all of `check_launch`."""
_FIND = re.compile(r"\$\(find ([^)]*)\)")


class LaunchError(SimulationToolsError):
    """Something cannot be launched as asked."""


@dataclass(frozen=True)
class Argument:
    """An <arg> of a launch file. text: default or value, unresolved; None: must be given."""

    name: str
    text: str | None = None
    fixed: bool = False


def arguments_of(path: Path) -> tuple[Argument, ...]:
    """Return the arguments of a launch file in their order; raises LaunchError."""
    return tuple(
        Argument(one.get("name", ""), one.get("value", one.get("default")), one.get("value") is not None)
        for one in _root(path).findall("arg")
    )


def check_arguments(path: Path, given: Mapping[str, str], defaults: Mapping[str, str]) -> None:
    """Check a launch file's arguments from the command line: names, and the type of each value.

    An argument whose default is a truth value or a number accepts only this type. defaults: by name, resolved
    ($(eval not gnss) is False).

    Raises:
        LaunchError: a sentence that names what is wrong, and what may have been meant.
    """
    known = {argument.name: argument for argument in arguments_of(path)}
    free = [name for name, argument in known.items() if not argument.fixed]
    for name, value in given.items():
        if name not in known:
            raise LaunchError(_unknown(path, name, free))
        if known[name].fixed:
            raise LaunchError(f"{path.name} sets its argument {name} itself; leave out {name}:={value}.")
        _check_kind(name, value, defaults.get(name, ""))
    missing = [name for name in free if known[name].text is None and name not in given]
    if missing:
        asked = " ".join(f"{name}:=..." for name in missing)
        raise LaunchError(f"{path.name} needs {asked}; roslaunch --ros-args tells what it means.")


def has_own_check(path: Path) -> bool:
    """Whether a launch file checks itself before it includes others; raises LaunchError."""
    return any(each.get("name") == OWN_CHECK and each.get("command") for each in _root(path).findall("param"))


def followed(path: Path, find: Callable[[str], str]) -> Path:
    """Return the file that a launch file stands for.

    It stands for another one if it does nothing but include that with all its arguments, as a file that moved
    does; else for itself. find: returns a package's folder.
    """
    parts = list(_root(path))
    if len(parts) != 1 or parts[0].get("pass_all_args") != "true" or len(parts[0]):
        return path
    return _place(parts[0].get("file", ""), find) or path


def _unknown(path: Path, name: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(name, list(known), n=1)
    meant = f"did you mean {close[0]}:=?" if close else f"it takes {', '.join(known)}."
    return f"{path.name} has no argument '{name}'; {meant}"


def _check_kind(name: str, value: str, default: str) -> None:
    if default.lower() in BOOLEANS and value.lower() not in BOOLEANS:
        raise LaunchError(f"'{value}' is no {name}; give {name}:=true or {name}:=false.")
    if _is_number(default) and not _is_number(value):
        raise LaunchError(f"'{value}' is no {name}; give a number, for example {name}:={default}.")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def nodes_of(path: Path, find: Callable[[str], str], namespace: str = "/") -> frozenset[str]:
    """Return the full names of the nodes that a launch file and those that it includes may start.

    find: returns a package's folder. If it raises, or if an include's path depends on arguments, the include
    is left out.
    """
    return frozenset(_nodes(_root(path), find, namespace.rstrip("/") + "/"))


def _nodes(element: ElementTree.Element, find: Callable[[str], str], namespace: str) -> Iterable[str]:
    for child in element:
        inner = namespace
        if child.get("ns"):
            ns = child.get("ns", "")
            inner = (ns if ns.startswith("/") else namespace + ns).rstrip("/") + "/"
        if child.tag == "node" and child.get("name"):
            yield inner + child.get("name", "")
        elif child.tag == "group":
            yield from _nodes(child, find, inner)
        elif child.tag == "include":
            path = _place(child.get("file", ""), find)
            if path is not None:
                yield from _nodes(_root(path), find, inner)


def _place(text: str, find: Callable[[str], str]) -> Path | None:
    try:
        path = Path(_FIND.sub(lambda match: find(match.group(1).strip()), text))
    except LookupError:
        return None
    return path if path.is_file() else None


def _root(path: Path) -> ElementTree.Element:
    try:
        return ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        reason = getattr(error, "strerror", None) or error
        raise LaunchError(f"The launch file {path} cannot be read: {reason}.") from None
