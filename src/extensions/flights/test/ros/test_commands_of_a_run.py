"""The commands that a run of an inspection starts at its end."""

import os
from types import SimpleNamespace

import pytest

rospy = pytest.importorskip("rospy", reason="needs ROS")
driver = pytest.importorskip(
    "flights_ros.inspecting.driver", reason="the workspace is not built, or not sourced"
)


def test_a_search_that_takes_too_long_is_told_and_the_run_goes_on(tmp_path, monkeypatch):
    # Given a rosrun that does not end within the time
    rosrun = tmp_path / "rosrun"
    rosrun.write_text("#!/bin/sh\nexec sleep 60\n")
    rosrun.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    monkeypatch.setattr(driver, "COMMAND_S", 0.2)
    said = []
    monkeypatch.setattr(driver.rospy, "logwarn", said.append)
    # Then the command counts as not done, and the sentence says how to do it
    assert driver._command("findings", "photographs", "--out", "findings.json") is False
    assert "so the results lack what it writes" in said[0]
    assert "rosrun inspection findings photographs --out findings.json" in said[0]


def test_after_an_interruption_the_calls_for_what_was_photographed_are_told(tmp_path, monkeypatch):
    # Given a run that was interrupted after some photographs, with a ship's file
    said = []
    monkeypatch.setattr(driver.rospy, "logwarn", said.append)
    driver._tell_what_is_left(
        "inspection", tmp_path, SimpleNamespace(source="hold.stl"), tmp_path / "ship.yaml"
    )
    # Then one warning says that the flight does not go on, and holds both calls, each in a line to paste
    (warning,) = said
    first, *calls = warning.splitlines()
    assert first.startswith("The inspection was interrupted, and no call continues the flight.")
    assert calls == [
        f"rosrun inspection findings {tmp_path}/photographs --mesh hold.stl --out {tmp_path}/findings.json",
        f"rosrun inspection inspection_report {tmp_path} --ship {tmp_path}/ship.yaml",
    ]


def test_ctrl_c_after_the_flight_tells_how_to_get_what_the_results_lack(monkeypatch):
    # Given a run whose flight was whole, and that is interrupted before its slow results
    from flights_ros.drivers.run import NAMED_IN, Run

    run, said = object.__new__(Run), []
    run.interrupted = False
    run._ending = SimpleNamespace(closes_by=lambda *_: None, received=True)
    run.folder = SimpleNamespace(seal=lambda *_: {"success": True})
    monkeypatch.setattr(rospy, "logwarn", said.append)
    monkeypatch.setenv(NAMED_IN, "elsewhere")
    # Then what tells how is called, after the sentence that says what is lacking
    code = run.finish({}, str, lambda content: content, "pictures", lambda: said.append("how"))
    assert (code, said) == (0, ["Interrupted: the results are without pictures.", "how"])
