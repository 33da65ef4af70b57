"""Peers beside our flight: installed from a registry, flown by turns; who fails has a sentence, no row."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import pytest

from benchmarks import sim
from benchmarks.peers import environments, flights, report, turns
from benchmarks.peers.catalogue import PEERS, Peer
from benchmarks.peers.environments import PeerError, make_ready
from benchmarks.shared.speed import Speed, medians, timed
from benchmarks.simulator import forest

NOBODY = "http://127.0.0.1:1/simple"  # no registry is on port 1
FLIES = "report.write(sys.argv[2], Speed(float(sys.argv[1]), 2.0, 4.0, 5.0), off_m=0.1)"


def peer(folder: Path, flight: str = FLIES, version: str = "1.0") -> Peer:
    """Return a peer whose only package is `fakesim`, in the local registry of `folder`."""
    lines = "import sys\nfrom benchmarks.peers import report\nfrom benchmarks.shared.speed import Speed\n"
    info = f"fakesim-{version}.dist-info"
    with zipfile.ZipFile(folder / f"fakesim-{version}-py3-none-any.whl", "w") as wheel:
        wheel.writestr("fakesim.py", lines + flight)
        wheel.writestr(f"{info}/METADATA", f"Metadata-Version: 2.1\nName: fakesim\nVersion: {version}\n")
        wheel.writestr(f"{info}/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        wheel.writestr(f"{info}/RECORD", "")
    pins = folder / "fakesim.txt"
    pins.write_text(f"# pinned\nfakesim=={version}\n")
    return Peer("fakesim", "nothing", pins, "fakesim")


@pytest.fixture
def registry(tmp_path, monkeypatch):
    """Be the only registry that pip knows: a folder."""
    for name, value in (
        ("PIP_CONFIG_FILE", "/dev/null"),
        ("PIP_NO_INDEX", "1"),
        ("PIP_FIND_LINKS", tmp_path),
    ):
        monkeypatch.setenv(name, str(value))
    return tmp_path


@pytest.fixture
def no_registry(monkeypatch):
    """Let no registry answer."""
    for name in ("PIP_NO_INDEX", "PIP_FIND_LINKS", "PIP_EXTRA_INDEX_URL"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    monkeypatch.setenv("PIP_INDEX_URL", NOBODY)
    monkeypatch.setattr(environments, "PATIENCE", ("--retries", "1", "--timeout", "5"))


def test_a_speed_is_simulated_time_by_each_clock():
    speed = Speed(simulated_s=60.0, thread_s=2.0, process_s=3.0, wall_s=4.0)
    assert (speed.rtf, speed.rtf_process, speed.rtf_wall) == (30.0, 20.0, 15.0)
    slower = Speed(60.0, 6.0, 6.0, 6.0)
    assert medians([speed, slower, slower]) == {"rtf": 10.0, "rtf_process": 10.0, "rtf_wall": 10.0}
    measured = timed(lambda: float(sum(range(100_000)) > 0))
    assert measured.simulated_s == 1.0
    assert min(measured.thread_s, measured.process_s, measured.wall_s) > 0.0


def test_each_peer_is_pinned_and_tells_why():
    assert PEERS.keys() == {"pyflyt", "crazyflow"}
    for known in PEERS.values():
        lines = known.requirements.read_text().splitlines()
        assert lines[0].startswith("# ")
        packages = [line for line in lines if line and not line.startswith("#")]
        assert all("==" in line for line in packages)
        assert not any(line.lower().startswith(("torch", "nvidia", "jax-cuda")) for line in packages)


@pytest.mark.long
@pytest.mark.flight
def test_a_peer_is_installed_once_and_flown(registry, no_network_after):
    known, folder = peer(registry), registry / "peers"
    python = make_ready(known, folder)
    assert flights.fly(known, python, 30.0) == Speed(30.0, 2.0, 4.0, 5.0)
    # Then no registry is needed
    no_network_after()
    assert make_ready(known, folder) == python
    # Until its pins change
    with pytest.raises(PeerError, match=r"^fakesim is not installed, because the package registry does not"):
        make_ready(peer(registry, version="1.1"), folder)


@pytest.fixture
def no_network_after(request):
    """Return what cuts the registry off."""
    return lambda: request.getfixturevalue("no_registry")


@pytest.mark.long
def test_a_registry_that_does_not_answer_is_told_in_one_sentence(tmp_path, no_registry):
    with pytest.raises(PeerError) as caught:
        make_ready(peer(tmp_path), tmp_path / "peers")
    assert str(caught.value) == (
        "fakesim is not installed, because the package registry does not answer: check the network "
        "or the proxy, and call again."
    )


@pytest.mark.long
def test_a_package_that_the_registry_has_not_is_named(registry):
    known = peer(registry)
    known.requirements.write_text("fakesim==7.0\n")
    with pytest.raises(PeerError, match=r"^fakesim cannot be installed: .*fakesim==7\.0.*\.$"):
        make_ready(known, registry / "peers")
    assert not (registry / "peers/fakesim/.ready").exists()


@pytest.mark.parametrize(
    ("flight", "sentence"),
    [
        ("import nothing_of_this_name", r"does not run: ModuleNotFoundError: .*nothing_of_this_name.*\.$"),
        ("sys.exit(3)", r"does not run: it ended with code 3 and said nothing\.$"),
        ("pass", r"left no figures: .*\.$"),
        ("open(sys.argv[2], 'w').write('{}')", r"left no figures: .*\.$"),
        (FLIES.replace("2.0", "0.0"), r"left no figures: the report has a time that is not positive: .*\.$"),
        (FLIES.replace("0.1", "0.4"), r"ended 0\.40 m from its goal, so its speed does not count\.$"),
        (FLIES.replace("0.1", "float('nan')"), r"ended nan m from its goal, so its speed does not count\.$"),
        ("import time; time.sleep(60.0)", r"did not end its flight within 1 s\.$"),
    ],
)
def test_a_flight_that_fails_is_told_in_one_sentence(tmp_path, monkeypatch, flight, sentence):
    monkeypatch.setattr(flights, "FLIGHT_S", 1.0 if "sleep" in flight else 60.0)
    known = peer(tmp_path, flight)
    with zipfile.ZipFile(next(tmp_path.glob("*.whl"))) as wheel:
        wheel.extractall(tmp_path / "site")
    monkeypatch.setattr(flights, "ROOT", f"{flights.ROOT}:{tmp_path / 'site'}")
    with pytest.raises(PeerError, match="^fakesim " + sentence):
        flights.fly(known, Path(environments.sys.executable), 30.0)


def test_a_python_that_is_gone_is_told_in_one_sentence(tmp_path):
    with pytest.raises(PeerError, match=r"^fakesim cannot be started: .*/python'\.$"):
        flights.fly(peer(tmp_path), tmp_path / "python")


def test_a_report_is_read_as_it_was_written(tmp_path):
    report.write(str(tmp_path / "report.json"), Speed(1.0, 2.0, 3.0, 4.0), 0.5)
    assert report.read(tmp_path / "report.json") == (Speed(1.0, 2.0, 3.0, 4.0), 0.5)


@pytest.fixture
def flown(monkeypatch):
    """Fly nothing: our factor is 40, PyFlyt's 20, crazyflow's 80 by the thread and 40 by the process."""
    order = []
    speeds = {"pyflyt": Speed(60.0, 3.0, 3.0, 3.0), "crazyflow": Speed(60.0, 0.75, 1.5, 1.0)}

    def ours(seed):
        order.append(seed)
        return Speed(20.0, 0.5, 0.5, 1.0)

    def theirs(known, python):
        order.append(known.name)
        return speeds[known.name]

    monkeypatch.setattr(forest, "fly", ours)
    monkeypatch.setattr(turns, "fly_peer", theirs)
    monkeypatch.setattr(turns, "make_ready", lambda known, folder: folder / known.name)
    return order


def test_peers_fly_by_turns_with_ours_and_are_compared(flown, tmp_path):
    ours, peers = forest.fly_beside(("pyflyt", "crazyflow"), 2, tmp_path)
    assert flown == [1, "pyflyt", "crazyflow", 2, "pyflyt", "crazyflow"]
    assert ours == {"rtf": 40.0, "rtf_process": 40.0, "rtf_wall": 20.0}
    assert (peers["pyflyt"]["ours_by_it"], peers["pyflyt"]["ours_by_it_process"]) == (2.0, 2.0)
    assert (peers["crazyflow"]["ours_by_it"], peers["crazyflow"]["ours_by_it_process"]) == (0.5, 1.0)


def test_a_peer_that_fails_has_a_sentence_and_the_rest_is_measured(flown, tmp_path, monkeypatch, capsys):
    def make(known, folder):
        if known.name == "pyflyt":
            raise PeerError("pyflyt cannot be installed: the disk is full.")
        return folder / known.name

    monkeypatch.setattr(turns, "make_ready", make)
    monkeypatch.setattr(sim, "FLIGHTS", 3)
    sim.main(["--results", str(tmp_path), "--parts", "inprocess", "--peers", "pyflyt", "crazyflow"])
    said = capsys.readouterr().out
    assert flown == [1, "crazyflow", 2, "crazyflow", 3, "crazyflow"]
    assert "Left out: pyflyt cannot be installed: the disk is full." in said.splitlines()
    row = next(line for line in said.splitlines() if line.startswith("| crazyflow"))
    assert [cell.strip() for cell in row.split("|")[2:7]] == ["80.0", "40.0", "60.0", "0.50", "1.00"]
    written = json.loads((tmp_path / "benchmarks.json").read_text())["sim"]
    assert written["peers"]["pyflyt"] == {"left_out": "pyflyt cannot be installed: the disk is full."}
    assert written["inprocess"]["rtf"] == 40.0


def test_a_peer_that_fails_once_flies_no_more(flown, tmp_path, monkeypatch):
    def theirs(known, python):
        flown.append(known.name)
        raise PeerError("pyflyt does not run: out of memory.")

    monkeypatch.setattr(turns, "fly_peer", theirs)
    ours, peers = forest.fly_beside(("pyflyt",), 3, tmp_path)
    assert flown == [1, "pyflyt", 2, 3]
    assert peers == {"pyflyt": {"left_out": "pyflyt does not run: out of memory."}}
    assert ours["rtf"] == 40.0


def test_peers_need_our_flight_beside_them(tmp_path, capsys):
    with pytest.raises(SystemExit):
        sim.main(["--results", str(tmp_path), "--parts", "raycast", "--peers", "pyflyt"])
    assert "name it in --parts, too" in capsys.readouterr().err
