"""Puts all pages, and what they refer to, into one folder, from which mkdocs builds the site."""

from __future__ import annotations

import ast
import shutil
from pathlib import Path

from handbook import library
from handbook.layout import with_captions, with_comments_above
from handbook.lists import spread
from handbook.pages import PICTURES, ROOT, all_pages, pictures, relative, with_links

GUIDE = "---\nsearch:\n  boost: 16\n---\n"
"""The search begins with tutorials and how-tos: they say what to do. Parameters (4) come next."""
UNSEARCHED = "---\nsearch:\n  exclude: true\n---\n"
LANGUAGES = {".py": "python", ".yaml": "yaml", ".rst": "rst", ".csv": "text", ".launch": "xml", "": "text"}
LONGEST_FENCE = "`````"
LEFT_OUT = {"__pycache__", "CATKIN_IGNORE"}


class Stage:
    """The folder in which the pages stand as mkdocs reads them, each at its place in the workspace.

    A link to a file that is no page leads to a page that shows this file. A link to a folder leads to a page
    that lists it, or to the reference of the Python package that it holds.
    """

    def __init__(self, folder: Path, root: Path = ROOT) -> None:
        self.folder, self.root = folder, root
        self.shown: set[Path] = set()
        """Pages that show a file or list a folder."""
        shutil.rmtree(folder, ignore_errors=True)

    def write(self, page: Path, text: str) -> None:
        """Write a page; the path is relative to the workspace."""
        (self.folder / page).parent.mkdir(parents=True, exist_ok=True)
        (self.folder / page).write_text(text, encoding="utf-8")

    def take(self, page: Path, front: str = "") -> None:
        """Take a page of the workspace, with the pictures and files that it refers to, behind `front`."""
        text = (self.root / page).read_text(encoding="utf-8")
        linked = with_links(text, lambda path: self._link(page, path))
        self.write(page, front + spread(with_captions(with_comments_above(linked))))

    def _link(self, page: Path, path: str) -> str:
        """Return what a page's link is in the site, and make what it leads to."""
        there = (self.root / page.parent / path).resolve()
        if not there.is_relative_to(self.root) or not there.exists():
            return path  # mkdocs names it
        target = there.relative_to(self.root)
        if there.is_dir():
            return relative(self._folder_page(target), page)
        if target.suffix == ".md":
            return path
        if target.suffix in PICTURES:
            (self.folder / target).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(there, self.folder / target)
            return path
        return relative(self._file_page(target), page)

    def _folder_page(self, folder: Path) -> Path:
        module = library.name_of(folder)
        if module:
            return library.page_of(module)
        page = folder / "files.md"
        if page not in self.shown:
            self.shown.add(page)
            self.write(page, f"{UNSEARCHED}# `{folder}/`\n\n{self._listing(folder)}")
        return page

    def _listing(self, folder: Path) -> str:
        paths = sorted(path for path in (self.root / folder).iterdir() if path.name not in LEFT_OUT)
        return "".join(f"- `{path.name}{'/' * path.is_dir()}`{_says(path)}\n" for path in paths)

    def _file_page(self, file: Path) -> Path:
        page = file.with_name(file.name + ".md")
        if page not in self.shown:
            self.shown.add(page)
            text = (self.root / file).read_text(encoding="utf-8")
            fence = f"{LONGEST_FENCE}{LANGUAGES.get(file.suffix, 'text')}\n{text}\n{LONGEST_FENCE}\n"
            self.write(page, f"{UNSEARCHED}# `{file}`\n\n{fence}")
        return page


def _says(path: Path) -> str:
    """Return the first line of what a module says of itself."""
    module = path / "__init__.py" if path.is_dir() else path
    if module.suffix != ".py" or not module.is_file():
        return ""
    line = (ast.get_docstring(ast.parse(module.read_text(encoding="utf-8"))) or "").partition("\n")[0]
    return f": {line}" if line else ""


def gallery(root: Path = ROOT) -> str:
    """Return the page of all pictures, each with its words and a link to the page that shows it."""
    parts = ["# Pictures\n\nEach picture stands on the page that its link names.\n"]
    seen = set()
    for page in all_pages(root):
        for words, file in pictures((root / page).read_text(encoding="utf-8")):
            path = (root / page.parent / file).resolve()
            if path.is_file() and path not in seen:
                seen.add(path)
                shown = path.relative_to(root).as_posix()
                parts.append(f"\n[![{words}]({shown})]({shown})\n\n{words} ([{page}]({page}))\n")
    return "".join(parts)
