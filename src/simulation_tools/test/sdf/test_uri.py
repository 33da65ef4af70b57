"""Where a uri may lead, and where not."""

from __future__ import annotations

import pytest

from simulation_tools.sdf.uri import UriError, model_path_from_environment, resolve


@pytest.fixture
def models(tmp_path):
    folder = tmp_path / "models"
    (folder / "crate" / "meshes").mkdir(parents=True)
    (folder / "crate" / "meshes" / "a.stl").write_text("x")
    (tmp_path / "secret.stl").write_text("x")
    return folder


def test_a_model_uri_is_looked_up_in_every_folder(models, tmp_path):
    found = resolve("model://crate/meshes/a.stl", [tmp_path / "none", models], None)
    assert found == models / "crate" / "meshes" / "a.stl"


@pytest.mark.parametrize(
    "uri",
    [
        "model://crate/../../secret.stl",
        "model://../secret.stl",
        "file:///etc/passwd",
        "../../../secret.stl",
        "/etc/passwd",
        "meshes/link.stl",
    ],
)
def test_no_uri_leaves_the_model_folders(models, uri):
    (models / "crate" / "meshes" / "link.stl").symlink_to(models.parent / "secret.stl")
    with pytest.raises(UriError, match=r"leaves the model folders|names no model"):
        resolve(uri, [models], models / "crate")


def test_a_model_folder_may_itself_be_a_link(models, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    (other / "linked").symlink_to(models / "crate")
    assert resolve("model://linked/meshes/a.stl", [other], None).name == "a.stl"


def test_relative_and_file_uris(models):
    expected = models / "crate" / "meshes" / "a.stl"
    assert resolve("meshes/a.stl", [], models / "crate") == expected
    assert resolve(f"file://{expected}", [models], None) == expected


@pytest.mark.parametrize("uri", ["model://crate/none.stl", "none.stl", "x" * 5000])
def test_what_does_not_exist_is_said(models, uri):
    with pytest.raises(UriError, match=r"does not exist|no model"):
        resolve(uri, [models], models / "crate")


def test_a_zero_byte_is_no_path(models):
    with pytest.raises(UriError, match="not a path"):
        resolve("a\0b", [models], models)


def test_the_shipped_models_are_found_without_any_setting(monkeypatch):
    monkeypatch.delenv("GAZEBO_MODEL_PATH", raising=False)
    assert resolve("model://iris", model_path_from_environment(), None).is_dir()


def test_a_file_is_looked_for_in_every_folder_that_has_the_model(models, tmp_path):
    second = tmp_path / "second"
    (second / "crate" / "meshes").mkdir(parents=True)
    (second / "crate" / "meshes" / "b.stl").write_text("x")
    found = resolve("model://crate/meshes/b.stl", [models, second], None)
    assert found == second / "crate" / "meshes" / "b.stl"


@pytest.mark.parametrize("uri", ["file://models/crate/meshes/a.stl", "models/crate/meshes/a.stl"])
def test_a_path_without_a_root_is_looked_for_in_the_resource_path(models, tmp_path, monkeypatch, uri):
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", f"{tmp_path / 'none'}:{tmp_path}")
    world_folder = tmp_path / "worlds"
    world_folder.mkdir()
    assert resolve(uri, [], world_folder) == models / "crate" / "meshes" / "a.stl"
    monkeypatch.delenv("GAZEBO_RESOURCE_PATH")
    with pytest.raises(UriError):
        resolve(uri, [], world_folder)


def test_the_resource_path_is_no_way_out_of_its_folders(models, tmp_path, monkeypatch):
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", str(models / "crate"))
    with pytest.raises(UriError, match="leaves the model folders"):
        resolve("file://../../secret.stl", [], None)


@pytest.fixture
def fuel(tmp_path, monkeypatch):
    """Return the folder of a model in Fuel's cache, in versions 2 and 10."""
    home = tmp_path / "fuel" / "fuel.ignitionrobotics.org" / "openrobotics" / "models" / "oak tree"
    for version in ("2", "10"):
        (home / version / "meshes").mkdir(parents=True)
        (home / version / "meshes" / "oak.dae").write_text("x")
    monkeypatch.setenv("IGN_FUEL_CACHE_PATH", str(tmp_path / "fuel"))
    monkeypatch.setenv("GZ_FUEL_CACHE_PATH", str(tmp_path / "none"))
    return home


@pytest.mark.table(
    ("uri", "rest"),
    [
        ("https://fuel.ignitionrobotics.org/1.0/OpenRobotics/models/Oak tree", "10"),
        ("https://fuel.gazebosim.org/1.0/openrobotics/models/oak%20tree", "10"),
        ("https://fuel.gazebosim.org/1.0/OpenRobotics/models/Oak tree/2", "2"),
        (
            "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Oak tree/tip/files/meshes/oak.dae",
            "10/meshes/oak.dae",
        ),
    ],
)
def test_a_model_of_fuel_comes_from_the_cache(fuel, uri, rest):
    assert resolve(uri, [], None) == fuel / rest


@pytest.mark.table(
    ("uri", "saying"),
    [
        ("https://fuel.gazebosim.org/1.0/OpenRobotics/models/Elm", "not in the local cache of Fuel"),
        ("https://fuel.gazebosim.org/1.0/OpenRobotics/models/Oak tree/3", "not in the local cache of Fuel"),
        ("https://fuel.gazebosim.org/1.0/x/models/../../y", "unknown scheme or names no model"),
        (
            "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Oak tree/2/files/../../../z",
            "local cache|leaves",
        ),
        ("https://example.org/tree.dae", "unknown scheme or names no model of Fuel"),
    ],
)
def test_what_is_not_in_the_cache_is_not_downloaded(fuel, uri, saying):
    with pytest.raises(UriError, match=saying):
        resolve(uri, [], None)


def test_a_folder_without_a_model_config_does_not_hide_a_model(models, tmp_path):
    (models / "crate" / "model.config").write_text("<model/>")
    meshes_only = tmp_path / "meshes_only"
    (meshes_only / "crate").mkdir(parents=True)
    assert resolve("model://crate", [meshes_only, models], None) == models / "crate"
    assert resolve("model://crate", [meshes_only], None) == meshes_only / "crate"


def test_a_package_is_looked_for_among_models_and_packages(models, tmp_path, monkeypatch):
    nested = tmp_path / "src" / "stack" / "robot"
    (nested / "meshes").mkdir(parents=True)
    (nested / "meshes" / "arm.stl").write_text("x")
    expected = nested / "meshes" / "arm.stl"
    assert resolve("package://crate/meshes/a.stl", [models], None) == models / "crate" / "meshes" / "a.stl"
    for folder in (tmp_path / "src", nested.parent, nested):  # a workspace, a stack, the package itself
        monkeypatch.setenv("ROS_PACKAGE_PATH", str(folder))
        assert resolve("package://robot/meshes/arm.stl", [], None) == expected
    for uri in ("package://robot/../../../secret.stl", "package://robot/none.stl", "package://../x"):
        with pytest.raises(UriError):
            resolve(uri, [], None)
