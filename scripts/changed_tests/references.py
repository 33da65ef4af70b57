"""What a file refers to: modules that it imports, and names that may be those of other files."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass, field
from typing import Iterable, Iterator

_WORD = re.compile(r"[\w.*-]+")
_XML_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_SUBSTITUTION = re.compile(r"\$\([^)]*\)|\$\{[^}]*\}")  # of roslaunch and of the shell
_ATTRIBUTE = re.compile(r'\b(pkg|type)="([^"]*)"')
_DOC = re.compile(r'\bdoc="[^"]*"')
_VALUE = re.compile(r'="([^"]*)"')
_COMMANDS = ("rosrun", "roslaunch")
_TEST_STARTS = re.compile(
    r"rosrun|roslaunch|devel/lib|start_node|subprocess|processes|ros_master|master_of|launched"
)
"""Signs of a test that starts nodes: commands, and the fixtures of conftest.py."""
_LEAST_CONSTANT = 4
"""Letters that a pattern needs beside its gaps: `*.py` could be anything."""


@dataclass
class References:
    """What one file refers to.

    modules: what it imports, dotted, with the imported name. words: of its strings, and pairs of words that
    follow each other ("cepa cepa" is a package and its node). patterns: words with a gap that only a running
    program fills, written `*` ("lidar_*", "*.world"). programs: whole strings, or values of attributes, that
    may be names of nodes and launch files that it starts. A word within a sentence is none.
    """

    modules: set[str] = field(default_factory=set)
    words: set[str] = field(default_factory=set)
    patterns: set[str] = field(default_factory=set)
    programs: set[str] = field(default_factory=set)

    def read(self, text: str) -> None:
        """Take the words of a text."""
        found = [word.strip(".") for word in _WORD.findall(text)]
        self.words.update(word for word in found if "*" not in word)
        self.patterns.update(
            word for word in found if "*" in word and len(word.replace("*", "")) >= _LEAST_CONSTANT
        )
        self.pair(found)

    def pair(self, words: Iterable[str]) -> None:
        """Take the pairs of words that follow each other."""
        listed = list(words)
        self.words.update(f"{first} {second}" for first, second in zip(listed, listed[1:]))


def of_text(text: str) -> References:
    """Return what a launch file, a rostest, a world, a configuration or a script of the shell refers to.

    Comments of XML and the descriptions (`doc`) of arguments do not count.
    """
    found = References()
    text = _SUBSTITUTION.sub("*", _DOC.sub("", _XML_COMMENT.sub("", text)))
    found.programs.update(map(str.strip, _VALUE.findall(text)))
    found.read(text)
    for line in text.split(">"):
        attributes = dict(_ATTRIBUTE.findall(line))
        if len(attributes) == 2:
            found.pair((attributes["pkg"], attributes["type"]))
    return found


def of_python(text: str, package: str, is_test: bool = False) -> References:
    """Return what Python code refers to. package: its own, for relative imports. Docstrings do not count.

    Raises:
        SyntaxError: it is no Python.
    """
    tree = ast.parse(text)
    found = References()
    starts = is_test and _TEST_STARTS.search(text) is not None
    strings: set[str] = set()
    docstrings = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found.modules.update(f"{name.name}.*" for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            found.modules.update(f"{_source(node, package)}.{name.name}" for name in node.names)
        elif isinstance(node, ast.JoinedStr):
            found.read("".join(_text(part) or "*" for part in node.values))
        elif _text(node) and id(node) not in docstrings:
            found.read(_text(node))
            strings.add(_text(node).strip())
            starts |= _text(node) in _COMMANDS
        else:
            found.pair(_neighbours(node))
    if starts:
        found.programs = strings
    return found


def code_of(text: str) -> str | None:
    """Return what Python runs of a source, without comments and docstrings; None: it reads its docstring.

    Raises:
        SyntaxError: it is no Python.
    """
    tree = ast.parse(text)
    if any(
        isinstance(node, (ast.Name, ast.Attribute)) and "__doc__" in ast.dump(node) for node in ast.walk(tree)
    ):
        return None
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [each for each in body if not (isinstance(each, ast.Expr) and _text(each.value))]
    return ast.dump(tree)


def _source(node: ast.ImportFrom, package: str) -> str:
    above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
    return ".".join([*above, *([node.module] if node.module else [])])


def _text(node: ast.AST) -> str:
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


def _neighbours(node: ast.AST) -> Iterator[str]:
    """Yield the strings beside each other in a call, a tuple, a list, or a path put together with /."""
    if isinstance(node, ast.Call):
        yield from map(_text, node.args)
    elif isinstance(node, (ast.Tuple, ast.List)):
        yield from map(_text, node.elts)
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div):
        left = node.left
        yield _text(left.right) if isinstance(left, ast.BinOp) else _text(left)
        yield _text(node.right)
