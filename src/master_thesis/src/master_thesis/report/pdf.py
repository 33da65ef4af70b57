"""Prints the page as PDF with a browser of this machine."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
PATIENCE_S = 120.0


def write_pdf(page: Path, pdf: Path) -> str:
    """Print a page into a file, if the machine has a program for it. Return a sentence about the result."""
    for name, command in _commands(page):
        program = shutil.which(name)
        if program is None:
            continue
        with tempfile.TemporaryDirectory() as folder:
            made = Path(folder) / "page.pdf"
            arguments = [part.format(pdf=made, profile=folder) for part in command]
            try:
                subprocess.run(
                    [program, *arguments], check=True, capture_output=True, text=True, timeout=PATIENCE_S
                )
                shutil.copyfile(made, pdf)
            except (OSError, subprocess.SubprocessError) as error:
                return f"{name} could not print the page ({type(error).__name__}), so there is no PDF."
        return f"The same as PDF: {pdf}"
    return "No PDF was made, because there is no chromium, google-chrome, wkhtmltopdf or weasyprint."


def _commands(page: Path) -> list[tuple[str, list[str]]]:
    """Return programs and their arguments; {pdf} and {profile} stand for paths."""
    address = page.resolve().as_uri()
    browser = [
        "--headless=new",
        "--no-sandbox",  # root has no sandbox; the page is our own, so this is safe
        "--disable-gpu",
        "--user-data-dir={profile}/browser",
        "--no-pdf-header-footer",
        "--print-to-pdf={pdf}",
        address.replace("{", "{{").replace("}", "}}"),
    ]
    others = [
        ("wkhtmltopdf", ["--quiet", "--enable-local-file-access", address, "{pdf}"]),
        ("weasyprint", [address, "{pdf}"]),
    ]
    return [(name, browser) for name in BROWSERS] + others
