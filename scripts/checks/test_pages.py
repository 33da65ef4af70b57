"""READMEs are short, and the maps of rooms show what exists."""

from __future__ import annotations

import importlib.util
import re
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
READMES = [ROOT / "README.md", ROOT / "benchmarks/README.md", *sorted((ROOT / "src").rglob("README.md"))]
OTHERS = [ROOT / "CONTRIBUTING.md", *sorted(ROOT.glob("doc/*.md")), *sorted(ROOT.glob("src/**/doc/*.md"))]
README_WORDS_MAX = 700

FOLDERS = ("src", "tests", "benchmarks", "scripts")
FILES = ["/px4.launch", "/apm.launch"]  # of MAVROS
FILES += [str(path) for folder in FOLDERS for path in (ROOT / folder).rglob("*.*")]

_spec = importlib.util.spec_from_file_location("room_maps", ROOT / "scripts/room_maps.py")
room_maps = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(room_maps)


def _name(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", READMES, ids=_name)
def test_a_readme_is_short(page):
    words = len(page.read_text(encoding="utf-8").split())
    assert words <= README_WORDS_MAX, f"{_name(page)} has {words} words: move a part to a page of its own"


@pytest.mark.parametrize("package", room_maps.PAGES)
def test_a_map_shows_the_rooms_that_exist(package):
    page = room_maps.PAGES[package]
    (written,) = room_maps.BLOCK.findall(page.read_text(encoding="utf-8"))
    made = room_maps.room_map(package)
    wrong = set(written.splitlines()) ^ set(made.splitlines())
    assert written == made, f"{_name(page)}: run scripts/room_maps.py. Lines that differ: {sorted(wrong)}"


def test_every_package_has_a_map():
    packages = {path.parent.name for path in ROOT.glob("src/**/setup.py")}
    assert room_maps.PAGES.keys() == packages


@pytest.mark.parametrize("page", [*READMES, *OTHERS], ids=_name)
def test_a_file_that_a_page_names_exists(page):
    named = re.findall(r"`([a-z0-9_./]+\.(?:py|launch|test|cfg|world))`", page.read_text(encoding="utf-8"))
    assert [name for name in named if not any(file.endswith(f"/{name}") for file in FILES)] == []


@pytest.mark.parametrize("page", sorted(ROOT.glob("src/**/*.md")), ids=_name)
def test_a_configuration_that_a_page_names_without_its_package_lies_in_the_own_one(page):
    package = next((folder for folder in page.parents if (folder / "package.xml").exists()), None)
    text = re.sub(r"\[[^\]]*\]\([^)]*\)", "", page.read_text(encoding="utf-8"))  # a link leads there
    named = re.findall(r"`(config/[^`\s]*)", text) if package else []
    shown = [name.partition("{")[0].partition("*")[0] for name in named]
    assert [name for name in shown if not list(package.glob(name.rstrip("/") + "*"))] == []


@pytest.mark.parametrize("package", room_maps.PAGES)
def test_the_readmes_list_every_node(package):
    """A package's README lists all its programs, but those that only launch files call."""
    nodes = {
        path.name
        for path in (room_maps.FOLDERS[package] / "nodes").glob("*")
        if path.is_file() and not path.suffix
    }
    own = (room_maps.FOLDERS[package] / "README.md").read_text(encoding="utf-8")
    assert {node for node in nodes if not re.search(rf"\b{node}\b", own)} <= {"check_launch", "check_flight"}
    launches = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("src/**/launch/**/*.launch"))
    started = set(re.findall(rf'pkg="{package}" type="(\w+)"', launches))
    (row,) = re.findall(rf"^\|[^|]*\[{package}\].*", (ROOT / "README.md").read_text(encoding="utf-8"), re.M)
    assert {node for node in started if f"`{node}`" not in row} == set()


@pytest.mark.parametrize("page", [*READMES, *OTHERS], ids=_name)
def test_each_column_of_a_table_has_a_head(page):
    text = re.sub(r"^( *)```.*?^\1```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    heads = re.findall(r"^ *\|(.*)\|\n *\|[-:| ]+\|$", text, re.M)
    assert [head for head in heads if not all(cell.strip() for cell in re.split(r"(?<!\\)\|", head))] == []


@pytest.mark.parametrize(
    ("number", "lacks"),
    [
        ("1", []),
        ("2", ["avoidance", "speed", "pose_source"]),
        ("3", ["scenario", "avoidance"]),
        ("4", ["scenario", "avoidance"]),
    ],
)
def test_the_arguments_of_experiment_1_mean_the_same_in_the_others_but_those_the_page_leaves_out(
    number, lacks
):
    """Experiment 2 shares those from `lidar` on. So `avoidance`, which stands before it, is not shared."""
    thesis = ROOT / "src/master_thesis"
    page = (thesis / "doc/experiments.md").read_text()
    first = page.partition("## Experiment 1\n")[2].partition("\n### ")[0]
    heads = re.findall(r"^- (.*?):", first.partition("Arguments (")[2], re.MULTILINE)
    listed = [name for head in heads for name in re.findall(r"`([a-z_]+)`", re.sub(r"\(.*?\)", "", head))]
    launch = (thesis / f"launch/experiment_{number}.launch").read_text()
    assert [name for name in listed if f'<arg name="{name}" default=' not in launch] == lacks
    about = "3 and 4" if number in "34" else number
    section = re.split(r"^## Experiments? ", page, flags=re.MULTILINE)
    (mine,) = (text for text in section if text.startswith(f"{about}\n"))
    shared = next((line for line in mine.splitlines() if "mean the same" in line), "")
    after = listed.index("lidar") if "from `lidar` on" in shared else 0
    assert set(re.findall(r"no `(\w+)`", shared)) == {name for name in lacks if name in listed[after:]}


def test_the_page_of_licences_names_every_requirement():
    page = (ROOT / "doc/licences.md").read_text(encoding="utf-8")
    rows = [line.split("|") for line in page.splitlines() if line.startswith("| ")]
    told = [name.strip() for row in rows for name in row[1].split(",")]
    lists = [ROOT / "requirements.txt", *(ROOT / "scripts/packages").glob("*.txt")]
    lines = [line for path in lists for line in path.read_text(encoding="utf-8").splitlines()]
    asked = {re.split(r"[=;< ]", line)[0] for line in lines if line and not line.startswith("#")}
    assert sorted(set(told) - {"package"}) == sorted(asked)


def test_no_folder_is_crowded():
    """It holds at most 15 modules."""
    modules = [path for path in ROOT.glob("src/**/*.py") if "test" not in path.parts]
    folders = Counter(path.parent for path in modules if path.name != "__init__.py")
    assert {str(folder): count for folder, count in folders.items() if count > 15} == {}
