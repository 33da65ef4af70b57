"""Parses XML of unknown origin safely: no entities, no document types, no network, a limited size.

Gazebo reads its files with TinyXML, which takes more than the standard allows. What it takes is taken here.
"""

from __future__ import annotations

import re

from lxml import etree

from simulation_tools.errors import SimulationToolsError

MAX_FILE_BYTES = 16 * 1024 * 1024
_COMMENT = re.compile(r"(<!\[CDATA\[.*?\]\]>)|<!--.*?-->", re.DOTALL)
_DECLARATION = re.compile(r"\s*<\?xml.*?\?>", re.DOTALL)
_BARE_AMPERSAND = re.compile(r"&(?!#?\w+;)")
_TAG = re.compile(r"<[^<>]*>")
_UNQUOTED = re.compile(r"""("[^"]*"|'[^']*')|=\s*([^\s"'<>/]+)""")
_PREFIX = re.compile(r"(</?[A-Za-z_][\w.-]*):(?=[A-Za-z_])")
_BARE_DOCTYPE = re.compile(rb"<!DOCTYPE[^\[<>]*>", re.IGNORECASE)
"""One that only names a type. It declares no entities, and nobody loads what it names."""
_DOCTYPE = re.compile(rb"<!DOCTYPE", re.IGNORECASE)
_BYTES_OF_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
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
        return _parse(_standard_xml(text))
    except etree.XMLSyntaxError:
        sentence = f"The file is not well-formed XML: {_first_sentence(error.msg)}"
        raise SdfError(f"{name}:{error.lineno or 1}: {sentence}.") from None


def _standard_xml(text: bytes) -> bytes:
    """Return the same elements as standard XML, each in its line.

    TinyXML takes blank lines before the declaration and any encoding, ``--`` in a comment, a bare ``&``, a
    value without quotes, a prefix without its namespace, and text after the last element.
    """
    try:
        plain = text.decode("utf-8-sig")
    except UnicodeDecodeError:
        plain = text.decode("latin-1")  # knows every byte; names and numbers are ASCII
    plain = _DECLARATION.sub(_lines_only, plain, count=1)
    plain = _COMMENT.sub(lambda found: found[1] or _lines_only(found), plain)
    plain = _BARE_AMPERSAND.sub("&amp;", plain)
    plain = _TAG.sub(lambda tag: _UNQUOTED.sub(_quoted, tag[0]), plain)
    plain = _PREFIX.sub(r"\1_", plain)
    last_end = plain.rfind("</")
    return plain[: plain.find(">", last_end) + 1].encode() if last_end >= 0 else plain.encode()


def _quoted(found: re.Match[str]) -> str:
    return found[0] if found[2] is None else f'="{found[2]}"'


def _bytes_lines_only(found: re.Match[bytes]) -> bytes:
    return b"\n" * found[0].count(b"\n")


def _lines_only(found: re.Match[str]) -> str:
    return "\n" * found[0].count("\n")


def _first_sentence(message: str | None) -> str:
    return re.sub(
        r",? line \d+, column \d+.*$", "", (message or "it is empty").strip(), flags=re.DOTALL
    ).rstrip(".")
