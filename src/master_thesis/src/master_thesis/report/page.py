"""The page: sections in one HTML file that needs no other file."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Sequence

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from flights.errors import ResultsError
from flights.files import replace_file
from flights.results.run_folder import machine, versions
from flights.trials.run import version
from flights.trials.store import Store
from flights.trials.trial import several_versions
from master_thesis.report import thesis
from master_thesis.report.content import Section
from master_thesis.report.piece import Piece

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Origin:
    """The origin of the report's numbers, for the head of the page."""

    date: str
    commits: Sequence[str]
    mixture: str | None
    machine: dict
    versions: dict
    size: str
    pieces: int
    of: int
    computed_min: float
    cpu_min: float
    first: str
    last: str
    greatest_load: float


def write_page(path: Path, sections: Sequence[Section], where_from: Origin) -> str:
    """Write the page; return its text.

    Raises:
        ResultsError: it cannot be written.
    """
    text = render(sections, where_from)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, text)
    except OSError as error:
        raise ResultsError(f"Cannot write {path}: {error.strerror}.") from None
    return text


def origin(size: str, pieces: Sequence[Piece], store: Store) -> Origin:
    """Return the origin of the numbers. size: its name; pieces: all of a report of this size."""
    rows = [row for row in map(store.get, pieces) if row is not None]
    here = machine()
    dates = sorted(row.date for row in rows)
    return Origin(
        date=datetime.now(UTC).strftime("%d %B %Y, %H:%M UTC"),
        commits=list(dict.fromkeys(row.commit for row in rows)) or [version()],
        mixture=several_versions(rows),
        machine={**here, "memory": _gigabytes(here["memory"])},
        versions={name: value for name, value in versions().items() if value},
        size=size,
        pieces=len(rows),
        of=len(pieces),
        computed_min=sum(row.wall_s for row in rows) / 60.0,
        cpu_min=sum(row.cpu_s for row in rows) / 60.0,
        first=dates[0].replace("T", " ")[:16] if dates else "-",
        last=dates[-1].replace("T", " ")[:16] if dates else "-",
        greatest_load=max((row.load for row in rows), default=0.0),
    )


def _gigabytes(memory: str | None) -> str | None:
    """Return "16777216 kB" as "16 GiB"."""
    words = (memory or "").split()
    return f"{int(words[0]) / 2**20:.0f} GiB" if len(words) == 2 and words[0].isdigit() else memory


def render(sections: Sequence[Section], where_from: Origin) -> str:
    """Return the page's HTML."""
    environment = Environment(
        loader=FileSystemLoader(str(HERE)),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        finalize=_typographic,
    )
    environment.filters["data_uri"] = _data_uri
    template = environment.get_template("page.html")
    return template.render(
        sections=sections,
        origin=where_from,
        thesis=thesis,
        css=(HERE / "page.css").read_text(encoding="utf-8"),
        findings=sum(len(section.findings) for section in sections),
        agreeing=sum(section.agreeing for section in sections),
        lone=sum(bool(finding.basis) for section in sections for finding in section.findings),
    )


def _typographic(value: object) -> object:
    """Return text with typographic apostrophes. HTML stays unchanged."""
    return value.replace("'", "\N{RIGHT SINGLE QUOTATION MARK}") if type(value) is str else value


def _data_uri(svg: bytes) -> str:
    """Return a picture as an inline image, so that its ids do not clash with another picture's."""
    return "data:image/svg+xml;base64," + base64.b64encode(svg).decode("ascii")
