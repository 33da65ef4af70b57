"""`./bringup.sh test --changed` runs what a change can touch: on a small workspace of two packages."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "scripts"))

from changed_tests import __main__ as command  # noqa: E402
from changed_tests.selection import Selection, select  # noqa: E402
from changed_tests.workspace import Workspace, package_of  # noqa: E402

ALPHA, BETA = "src/alpha/src/alpha", "src/beta/src/beta"
FILES = {
    "conftest.py": "",
    "README.md": "the geometry of alpha",
    "src/alpha/package.xml": "<package><name>alpha</name><depend>beta</depend></package>",
    "src/beta/package.xml": "<package><name>beta</name></package>",
    f"{ALPHA}/__init__.py": "",
    f"{ALPHA}/geometry.py": "A = 1",
    f"{ALPHA}/speed.py": "from . import geometry",
    f"{ALPHA}/worlds.py": "def path(name): return f'{name}.world'",
    f"{ALPHA}/commands.py": "import subprocess\nsubprocess.run(['rosrun', 'alpha', 'saver'])",
    f"{BETA}/__init__.py": "def __getattr__(name): return getattr(import_module('beta.library'), name)",
    f"{BETA}/library.py": "from beta.far import far",
    f"{BETA}/far.py": "far = 1",
    f"{BETA}/near.py": "near = 1",
    "src/alpha/nodes/flyer": "#!/usr/bin/env python3\nfrom alpha.speed import A",
    "src/alpha/nodes/saver": "#!/usr/bin/env python3\nimport beta.near",
    "src/alpha/launch/fly.launch": '<launch><node pkg="alpha" type="flyer" name="x"/></launch>',
    "src/alpha/launch/any.launch": '<launch><node pkg="alpha" type="$(arg node)" name="x"/></launch>',
    "src/alpha/worlds/room.world": "<sdf><include><uri>model://box</uri></include></sdf>",
    "src/alpha/models/box/model.sdf": "<sdf/>",
    "src/alpha/config/room_map.yaml": "a: 1",
    "src/alpha/data/nobody.bin": "",
    "src/alpha/test/conftest.py": "import drawn",
    "src/alpha/test/drawn.py": "from beta.near import near",
    "src/alpha/test/test_geometry.py": "from alpha.geometry import A",
    "src/alpha/test/test_speed.py": "import alpha.speed",
    "src/alpha/test/test_worlds.py": '"""No hall."""\nfrom alpha.worlds import path\nROOM = path("room")',
    "src/alpha/test/test_maps.py": "def test(name): open(f'{name}_map.yaml')",
    "src/alpha/test/test_all_models.py": "MODELS = 1\nNAMES = MODELS.glob('*')",
    "src/alpha/test/test_commands.py": "import alpha.commands",
    "src/alpha/test/ros/flyer.test": '<launch><test pkg="alpha" type="rostest_flyer.py"/>'
    '<include file="$(find alpha)/launch/fly.launch"/></launch>',
    "src/alpha/test/ros/rostest_flyer.py": "import rostest",
    "src/beta/test/test_near.py": "from beta.near import near",
    "src/beta/test/test_far.py": "from beta import far",
    "tests/test_rostests.py": "",
    "tests/flights/test_flight.py": "def test(launched): launched('fly')",
    "tests/flights/test_nodes.py": "def test(processes): processes.start_node('alpha', 'saver')",
    # Words of sentences, and the name of a module that several packages have: nothing is started or imported
    "src/beta/launch/other.launch": '<launch><arg name="a" doc="as the flyer does after fly"/></launch>',
    "src/beta/test/test_words.py": "import subprocess\nassert 'the flyer may fly'",
    f"{BETA}/folders.py": "def has(folder): return (folder / 'geometry.py').is_file()",
    "src/beta/test/test_folders.py": "import beta.folders",
    "tests/pages/test_links.py": "",
}
LOOK_AT_ALL = {"src/alpha/test/test_all_models.py", "tests/pages/test_links.py"}
OF_ALPHA = {path for path in FILES if path.startswith("src/alpha/test/test_")}
OF_BETA = {path for path in FILES if path.startswith("src/beta/test/test_")}
FLYER = "tests/test_rostests.py::test_rostest[alpha/flyer]"


@pytest.fixture
def workspace(tmp_path):
    for path, text in FILES.items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text)
    return tmp_path


def selected(root: Path, *changed: str) -> Selection:
    return select(Workspace(root, {*FILES, *changed}), changed)


@pytest.mark.parametrize(
    ("changed", "tests"),
    [
        # Imports: of a module, of one that imports it, by a node, which a rostest and a flight start
        (
            f"{ALPHA}/geometry.py",
            {
                "src/alpha/test/test_geometry.py",
                "src/alpha/test/test_speed.py",
                FLYER,
                "tests/flights/test_flight.py",
            },
        ),
        ("src/alpha/nodes/flyer", {FLYER, "tests/flights/test_flight.py"}),
        ("src/alpha/nodes/saver", {"tests/flights/test_nodes.py", "src/alpha/test/test_commands.py"}),
        ("src/alpha/launch/fly.launch", {FLYER, "tests/flights/test_flight.py"}),
        # A package that imports its modules only when asked for a name
        (f"{BETA}/far.py", {"src/beta/test/test_far.py"}),
        # Helpers beside tests, and what a conftest needs
        (
            f"{BETA}/near.py",
            {"src/beta/test/test_near.py", "tests/flights/test_nodes.py", FLYER, *OF_ALPHA},
        ),
        ("src/alpha/test/drawn.py", {FLYER, *OF_ALPHA}),
        # Tests and rostests themselves
        ("src/beta/test/test_near.py", {"src/beta/test/test_near.py"}),
        ("src/alpha/test/ros/flyer.test", {FLYER}),
        ("src/alpha/test/ros/rostest_flyer.py", {FLYER}),
        ("tests/test_rostests.py", {FLYER}),
        # Data: by its name, by a pattern of it, by a world that has the model
        ("src/alpha/worlds/room.world", {"src/alpha/test/test_worlds.py"}),
        ("src/alpha/models/box/model.sdf", {"src/alpha/test/test_worlds.py"}),
        ("src/alpha/config/room_map.yaml", {"src/alpha/test/test_maps.py"}),
        # What the build of a package reads: it, and the packages that need it
        (
            "src/alpha/CMakeLists.txt",
            {*OF_ALPHA, FLYER, "tests/flights/test_flight.py", "tests/flights/test_nodes.py"},
        ),
        (
            "src/beta/msg/B.msg",
            {*OF_ALPHA, *OF_BETA, FLYER, "tests/flights/test_flight.py", "tests/flights/test_nodes.py"},
        ),
        ("src/mine/package.xml", set()),
        ("src/mine/nodes/new", set()),
        # What no file names
        (
            "src/alpha/data/nobody.bin",
            {*OF_ALPHA, FLYER, "tests/flights/test_flight.py", "tests/flights/test_nodes.py"},
        ),
        # Pages
        ("README.md", set()),
        ("src/alpha/doc/picture.png", set()),
    ],
)
def test_a_change_selects_the_tests_that_it_can_touch(workspace, changed, tests):
    assert set(selected(workspace, changed).arguments) == tests | LOOK_AT_ALL


def test_what_used_a_deleted_file_is_selected(workspace):
    (workspace / ALPHA / "geometry.py").unlink()
    (workspace / "src/beta/test/test_far.py").unlink()
    found = selected(workspace, f"{ALPHA}/geometry.py", "src/beta/test/test_far.py")
    assert {"src/alpha/test/test_geometry.py", "src/alpha/test/test_speed.py"} <= set(found.arguments)
    assert "src/beta/test/test_far.py" not in found.arguments


@pytest.mark.parametrize(
    "changed",
    [
        *("conftest.py", "bringup.sh", "pyproject.toml", "requirements.txt", "scripts/setup.sh", ".ci/run"),
        *("scripts/packages/debian-12.txt", "src/alpha/env-hooks/10.alpha.sh"),
    ],
)
def test_what_set_up_or_each_test_reads_selects_all(workspace, changed):
    found = selected(workspace, changed, f"{BETA}/far.py")
    assert found.arguments == ("src", "tests")
    assert found.sentence() == f"All tests run: {changed} can touch each of them."


def test_what_cannot_be_placed_selects_all_and_is_told(workspace):
    found = selected(workspace, "nobody.bin")
    assert found.arguments == ("src", "tests")
    assert found.sentence() == "All tests run: no file names nobody.bin."
    (workspace / ALPHA / "speed.py").write_text("def (")
    found = selected(workspace, f"{ALPHA}/geometry.py")
    assert found.arguments == ("src", "tests")
    assert found.sentence().startswith(f"All tests run: {ALPHA}/speed.py is no Python (line 1: ")


def test_what_is_left_out_is_counted_by_package(workspace):
    left_out = selected(workspace, f"{BETA}/far.py")
    assert left_out.sentence() == (
        "Left out, because the change cannot touch them (files): alpha 5 of 6, beta 3 of 4, rostests 1 of 1, "
        "tests/flights 2 of 2."
    )
    assert selected(workspace).sentence() == "Nothing has changed, so no test runs."


# -- what git tells -----------------------------------------------------------------------------------------


@pytest.fixture
def repository(workspace):
    """A branch of main, with a committed, a staged, an unstaged, a new, a deleted and a renamed file."""
    if not shutil.which("git"):
        pytest.skip("needs git")

    def git(*words: str) -> None:
        who = ("-c", "user.name=a", "-c", "user.email=a@b.c", "-c", "commit.gpgsign=false")
        subprocess.run(("git", *who, *words), cwd=workspace, check=True, capture_output=True)

    git("init", "--initial-branch", "main")
    (workspace / ".gitignore").write_text("*.log\n")
    git("add", ".")
    git("commit", "--message", "main")
    git("checkout", "-b", "branch")
    (workspace / ALPHA / "speed.py").write_text("B = 1")
    git("commit", "--all", "--message", "committed")
    (workspace / ALPHA / "worlds.py").write_text("staged = 1")
    git("add", ".")
    (workspace / BETA / "far.py").write_text("unstaged = 1")
    (workspace / "new file.py").write_text("")
    (workspace / "left.log").write_text("")
    (workspace / BETA / "near.py").unlink()
    git("mv", f"{ALPHA}/commands.py", f"{ALPHA}/called.py")
    return workspace


def test_a_change_is_what_differs_from_the_start_of_the_branch(repository):
    uncommitted = [
        *(f"{ALPHA}/called.py", f"{ALPHA}/commands.py", f"{ALPHA}/worlds.py"),
        *("new file.py", f"{BETA}/far.py", f"{BETA}/near.py"),
    ]
    since = command.start_of_branch(repository)
    assert command.changed_files(repository, since) == sorted([*uncommitted, f"{ALPHA}/speed.py"])
    head = command.commit(repository, "HEAD")
    assert command.changed_files(repository, head) == sorted(uncommitted)


def test_the_command_prints_arguments_and_tells_what_is_left_out(repository, capsys):
    assert command.main(["HEAD"], repository) == 0
    told = capsys.readouterr()
    assert set(told.out.split()) == OF_ALPHA | {
        *("src/beta/test/test_near.py", "src/beta/test/test_far.py"),
        *("tests/flights/test_nodes.py", "tests/pages/test_links.py", FLYER),
    }
    assert ": 6 file(s). Left out, because " in told.err
    assert told.err.endswith("(files): beta 2 of 4, tests/flights 1 of 2.\n")
    assert len(told.err.splitlines()) == 1


def test_a_change_of_comments_and_docstrings_selects_no_importer(repository, capsys):
    subprocess.run(("git", "checkout", "--force", "main"), cwd=repository, check=True, capture_output=True)
    (repository / "new file.py").unlink(missing_ok=True)
    far = repository / BETA / "far.py"
    far.write_text('"""How far it is."""\n# m\nfar = 1')
    assert command.main(["HEAD"], repository) == 0
    assert set(capsys.readouterr().out.split()) == LOOK_AT_ALL
    far.write_text('"""How far it is."""\nfar = 2')
    assert command.main(["HEAD"], repository) == 0
    assert set(capsys.readouterr().out.split()) == {"src/beta/test/test_far.py", *LOOK_AT_ALL}


@pytest.mark.parametrize("name", ["nothing", "--output=x"])
def test_a_commit_that_git_does_not_know_is_told_in_one_sentence(repository, capsys, name):
    assert command.main([name], repository) == 1
    told = capsys.readouterr()
    assert told.err == f"Git knows no commit '{name}'; give --changed a branch, a tag or a hash.\n"
    assert told.out == ""


def test_no_repository_and_no_git_are_told_in_one_sentence(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    if shutil.which("git"):
        assert command.main([], tmp_path) == 1
        assert capsys.readouterr().err.startswith(f"Git cannot tell what has changed in {tmp_path} (")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert command.main([], tmp_path) == 1
    assert capsys.readouterr().err == "--changed needs git; without it, call ./bringup.sh test.\n"


@pytest.mark.parametrize(
    ("path", "package"),
    [("src/alpha/setup.py", "alpha"), ("src/extensions/gamma/nodes/a", "gamma"), ("tests/code/a.py", "")],
)
def test_a_package_may_lie_in_a_folder_of_packages(path, package):
    assert package_of(path) == package
