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
