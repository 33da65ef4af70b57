"""Rewrites what TinyXML takes, Gazebo's reader of XML, as standard XML.

TinyXML takes more than the standard allows: blank lines before the declaration and any encoding, ``--`` in a
comment, a bare ``&`` and entities that nobody has declared, ``<`` in a value, values without quotes or with
no blank behind them, ``]]>`` and control characters in a text, prefixes without a namespace, several elements
at the top, and text behind them.
"""

from __future__ import annotations

import re

TOP = "_"
"""Tag of the element that holds the elements at the top."""
_COMMENT, _DATA, _INSTRUCTION = ("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")
_BARE_AMPERSAND = re.compile(r"&(?!(?:amp|lt|gt|quot|apos|#\d+|#x[0-9a-fA-F]+);)")
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")
_NAME = re.compile(r"[A-Za-z_][\w.:-]*")
_QUOTE_OR_END = re.compile(r"[\"'>]")
_ATTRIBUTE = re.compile(r"""\s*([^\s=/>"']+)\s*=\s*(?:"([^"]*)"|'([^']*)'|([^\s"'<>/]+))""")


def standard_xml(text: bytes) -> bytes:
    """Return the elements at the top inside an element `TOP`, each element in its line of the text.

    Raises:
        ValueError: TinyXML does not take the text, either.
    """
    try:
        plain = text.decode("utf-8-sig")
    except UnicodeDecodeError:
        plain = text.decode("latin-1")  # knows every byte; names and numbers are ASCII
    plain = _CONTROL.sub(" ", plain)
    return f"<{TOP}>{''.join(_pieces(plain))}</{TOP}>".encode()


def _pieces(plain: str) -> list[str]:
    """Return the pieces of standard XML. Behind the first text at the top nothing counts."""
    found, at, depth = [], 0, 0
    while at < len(plain):
        if plain[at] != "<":
            end = plain.find("<", at)
            end = len(plain) if end < 0 else end
            if not depth and plain[at:end].strip():
                break
            found.append(_escaped(plain[at:end]))
        elif plain.startswith(_DATA[0], at):
            end = _behind(plain, _DATA, at)
            found.append(plain[at:end])
        elif name := _NAME.match(plain, at + 1):
            end = _end_of_tag(plain, name.end())
            found.append(_start_tag(name[0], plain[name.end() : end - 1]))
            depth += plain[end - 2] != "/"
        elif plain.startswith("</", at):
            end = _behind(plain, ("</", ">"), at)
            found.append(f"</{plain[at + 2 : end - 1].strip().replace(':', '_')}>" + _lines(plain[at:end]))
            depth -= 1
        else:
            kinds = (_COMMENT, _INSTRUCTION, ("<", ">"))
            end = _behind(plain, next(kind for kind in kinds if plain.startswith(kind[0], at)), at)
            found.append(_lines(plain[at:end]))
        at = end
    return found


def _behind(plain: str, kind: tuple[str, str], at: int) -> int:
    """Return where a piece ends that begins and ends with certain signs."""
    end = plain.find(kind[1], at + len(kind[0]))
    if end < 0:
        raise ValueError(f"{kind[1]} is missing")
    return end + len(kind[1])


def _end_of_tag(plain: str, at: int) -> int:
    """Return where a start tag ends, behind the ``>`` that no quotes hold."""
    while sign := _QUOTE_OR_END.search(plain, at):
        if sign[0] == ">":
            return sign.end()
        at = _behind(plain, (sign[0], sign[0]), sign.start())
    raise ValueError("> is missing")


def _start_tag(name: str, rest: str) -> str:
    ends = rest.endswith("/")
    values = rest[:-1] if ends else rest
    attributes, at = "", 0
    while found := _ATTRIBUTE.match(values, at):
        key, value = found[1], next(each for each in found.groups()[1:] if each is not None)
        at = found.end()
        if not key.startswith("xmlns"):  # TinyXML knows no namespaces
            quoted = _escaped(value).replace('"', "&quot;")
            attributes += f' {key.replace(":", "_")}="{quoted}"'
    if values[at:].strip():
        raise ValueError("an attribute has no value")
    return f"<{name.replace(':', '_')}{_lines(rest)}{attributes}{'/' if ends else ''}>"


def _escaped(text: str) -> str:
    return _BARE_AMPERSAND.sub("&amp;", text).replace("<", "&lt;").replace("]]>", "]]&gt;")


def _lines(text: str) -> str:
    return "\n" * text.count("\n")
