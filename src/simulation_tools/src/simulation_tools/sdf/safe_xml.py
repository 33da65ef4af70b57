"""Parses XML of unknown origin safely: no entities, no document types, no network, a limited size."""

from __future__ import annotations

import re

from lxml import etree

from simulation_tools.errors import SimulationToolsError

MAX_FILE_BYTES = 16 * 1024 * 1024


class SdfError(SimulationToolsError):
    """A description file cannot be used; the text is ``PATH:LINE: sentence``."""


def parse_xml(text: bytes, name: str) -> etree._Element:
    """Return the root element. name: stands for the path in errors. Raises SdfError.

    No entity is expanded and no document type is loaded. A description needs neither, and attacks use both.
    """
    if len(text) > MAX_FILE_BYTES:
        raise SdfError(f"{name}:1: The text is larger than {MAX_FILE_BYTES // 2**20} MB.")
    prolog = re.search(rb"<!DOCTYPE", text, re.IGNORECASE)
    if prolog:
        line = text.count(b"\n", 0, prolog.start()) + 1
        raise SdfError(f"{name}:{line}: A document type (<!DOCTYPE ...>) is not allowed.")
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        root = etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        line = error.lineno or 1
        raise SdfError(
            f"{name}:{line}: The file is not well-formed XML: {_first_sentence(error.msg)}."
        ) from None
    if root.getroottree().docinfo.internalDTD is not None:  # in an encoding that the search above cannot see
        raise SdfError(f"{name}:1: A document type (<!DOCTYPE ...>) is not allowed.")
    return root


def _first_sentence(message: str | None) -> str:
    return re.sub(
        r",? line \d+, column \d+.*$", "", (message or "it is empty").strip(), flags=re.DOTALL
    ).rstrip(".")
