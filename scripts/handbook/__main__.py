"""Build the handbook: one folder of HTML pages that opens without a server.

usage: python -m handbook [--out FOLDER]

The build fails, and names what is wrong, if a link leads nowhere, a picture has no text, a page is in no
menu, or a parameter of a node has no sentence.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

from handbook import library
from handbook.pages import ROOT, all_pages, without_words
from handbook.parameters import tables
from handbook.staging import GUIDE, Stage, gallery

HERE = Path(__file__).resolve().parent
SEARCH = Path("file-search/iframe-worker.js")
"""Material takes a file of this name for what lets its search work without a server."""

MARK = SEARCH
"""A folder that has this file holds a handbook, which the next build may replace."""


def stage_all(folder: Path, is_quick: bool = False) -> Stage:
    """Write all pages into the folder. is_quick: those of the libraries are empty."""
    stage = Stage(folder)
    guides = pages_of("Tutorials", "How-to")
    for page in all_pages():
        stage.take(page, GUIDE if page in guides else "")
    stage.write(Path("pictures.md"), gallery())
    for package, place in library.packages().items():
        text = f"# {package}\n" if is_quick else library.page(package, place)
        stage.write(library.page_of(package), text)
    for page, text in tables.pages(tables.known_parameters()):
        stage.write(page, text)
    stage.write(SEARCH, (HERE / "file-search.js").read_text(encoding="utf-8"))
    stage.write(Path("handbook.css"), (HERE / "handbook.css").read_text(encoding="utf-8"))
    return stage


def pages_of(*parts: str) -> set[Path]:
    """Return the pages in parts of the menu, by the titles of these."""
    menu = (HERE / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:")[2]
    found: set[Path] = set()
    for part in re.split(r"\n  - ", menu):
        if part.partition(":")[0] in parts:
            found |= set(map(Path, re.findall(r"[\w./]+\.md\b", part)))
    return found


def faults() -> list[str]:
    """Return what is wrong with the pages that mkdocs does not look for."""
    bare = [
        f"{page}: the picture {file} has no text." for page in all_pages() for file in without_words(page)
    ]
    return bare + tables.faults(tables.known_parameters())


def configuration(stage: Stage, out: Path) -> str:
    """Return mkdocs's configuration, with the pages that are made here."""
    import yaml

    text = (HERE / "mkdocs.yml").read_text(encoding="utf-8")
    config = yaml.load(text, yaml.UnsafeLoader)  # ours; it names a function, as Material's pages do
    config |= {"docs_dir": str(stage.folder), "site_dir": str(out)}
    nav = {title: entry for part in config["nav"] for title, entry in part.items()}
    made = sorted(
        page.relative_to(stage.folder).as_posix() for page in (stage.folder / tables.FOLDER).glob("*")
    )
    nav["Reference"].insert(0, {"Parameters of all nodes": [{Path(page).stem: page} for page in made]})
    nav["Reference"].append({"Libraries": [str(library.page_of(name)) for name in library.packages()]})
    nav["More"].append("pictures.md")
    config["not_in_nav"] = "".join(f"/{page.as_posix()}\n" for page in sorted(stage.shown))
    config["plugins"]["mkdocstrings"]["handlers"]["python"]["paths"] = [
        str(path) for path in sorted(ROOT.glob("src/**/src"))
    ]
    return yaml.dump(config)


def main() -> int:
    """Build the site; the exit code tells whether all is well."""
    parser = argparse.ArgumentParser(prog="./bringup.sh docs", description=__doc__.partition("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "results/handbook", help="folder of the site")
    parser.add_argument("--quick", action="store_true", help="leave the pages of the libraries empty")
    given = parser.parse_args()
    out = given.out.resolve()
    if out.exists() and not (out / MARK).is_file() and (not out.is_dir() or any(out.iterdir())):
        print(
            f"{out} exists and holds no handbook: choose another folder, which this may replace.",
            file=sys.stderr,
        )
        return 1
    print("handbook: reading the pages and the parameters ...", flush=True)  # minutes on a busy machine
    wrong = faults()
    for sentence in wrong:
        print(sentence, file=sys.stderr)
    if wrong:
        return 1
    work = ROOT / ".docs/work"
    built = work / "site"
    stage = stage_all(work / "pages", given.quick)
    (work / "mkdocs.yml").write_text(configuration(stage, built), encoding="utf-8")
    print(f"handbook: mkdocs makes {len(list(stage.folder.rglob('*.md')))} pages ...", flush=True)
    if not build(work / "mkdocs.yml"):
        return 1
    shutil.rmtree(out, ignore_errors=True)
    out.parent.mkdir(parents=True, exist_ok=True)
    shutil.move(built, out)
    print(f"handbook: {len(list(out.rglob('*.html')))} pages; open {out / 'index.html'}")
    return 0


def build(config: Path) -> bool:
    """Let mkdocs build the site; print what it warns of, each of which fails the build."""
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--config-file", str(config)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    said = done.stdout.splitlines()
    for line in said if done.returncode and "WARNING" not in done.stdout else ():
        print(line, file=sys.stderr)
    for line in said:
        if line.startswith(("WARNING", "ERROR")):
            print(line, file=sys.stderr)
    return done.returncode == 0


if __name__ == "__main__":
    sys.exit(main())
