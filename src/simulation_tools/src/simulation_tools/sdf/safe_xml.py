"""Parses XML of unknown origin safely: no entities, no document types, no network, a limited size.

Gazebo reads its files with TinyXML, which takes more than the standard allows. What it takes is taken here.
"""

from __future__ import annotations

import re

from lxml import etree

from simulation_tools.errors import SimulationToolsError
from simulation_tools.sdf.tinyxml import standard_xml

MAX_FILE_BYTES = 16 * 1024 * 1024
_BARE_DOCTYPE = re.compile(rb"<!DOCTYPE[^\[<>]*>", re.IGNORECASE)
"""One that only names a type. It declares no entities, and nobody loads what it names."""
_DOCTYPE = re.compile(rb"<!DOCTYPE", re.IGNORECASE)
_BYTES_OF_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
ROOTS = "sdf", "gazebo", "robot"
"""Tags of a description's root. Behind other elements TinyXML finds it, too."""
_NO_TYPE = (
    "A document type (<!DOCTYPE ...>) with declarations is not allowed. Take this element out of the file."
)


class SdfError(SimulationToolsError):
    """A description file cannot be used; the text is ``PATH:LINE: sentence`` (of no file: no line)."""


def parse_xml(text: bytes, name: str) -> etree._Element:
    """Return the root element. name: stands for the path in errors. Raises SdfError.

    No entity is expanded and no document type is loaded. A description needs neither, and attacks use both.
    So a document type that declares nothing is passed over, as in Gazebo. Any other one is refused.
    """
    if len(text) > MAX_FILE_BYTES:
        raise SdfError(f"{name}:1: The text is larger than {MAX_FILE_BYTES // 2**20} MB.")
    text = _BARE_DOCTYPE.sub(_bytes_lines_only, text, count=1)
    without_comments = _BYTES_OF_COMMENT.sub(_bytes_lines_only, text)
    prolog = _DOCTYPE.search(without_comments)
    if prolog:
        line = without_comments.count(b"\n", 0, prolog.start()) + 1
        raise SdfError(f"{name}:{line}: {_NO_TYPE}")
    try:
        root = _parse(text)
    except etree.XMLSyntaxError as error:
        root = _parse_as_tinyxml(text, name, error)
    if root.getroottree().docinfo.internalDTD is not None:  # in an encoding that the search above cannot see
        raise SdfError(f"{name}:1: {_NO_TYPE}")
    return root


def _parse(text: bytes) -> etree._Element:
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    root = etree.fromstring(text, parser)
    for element in root.iter():  # TinyXML knows no namespaces
        if element.prefix is None and isinstance(element.tag, str):
            element.tag = etree.QName(element).localname
    return root


def _parse_as_tinyxml(text: bytes, name: str, error: etree.XMLSyntaxError) -> etree._Element:
    """Parse what TinyXML takes and the standard refuses; raise the first error as SdfError if it stays."""
    try:
        top = list(_parse(standard_xml(text)))
        root = next((element for element in top if element.tag in ROOTS), top[0])
    except (etree.XMLSyntaxError, ValueError, IndexError):
        sentence = f"The file is not well-formed XML: {_first_sentence(error.msg)}"
        raise SdfError(f"{name}:{error.lineno or 1}: {sentence}.") from None
    top[0].getparent().remove(root)
    return root


def _bytes_lines_only(found: re.Match[bytes]) -> bytes:
    return b"\n" * found[0].count(b"\n")


def _first_sentence(message: str | None) -> str:
    return re.sub(
        r",? line \d+, column \d+.*$", "", (message or "it is empty").strip(), flags=re.DOTALL
    ).rstrip(".")
