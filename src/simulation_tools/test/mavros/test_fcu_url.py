"""Which addresses an fcu_url stands for, and what is said of one that stands for none."""

from __future__ import annotations

import pytest

from simulation_tools.mavlink import LinkError
from simulation_tools.mavros.fcu_url import Endpoints, parse_fcu_url


@pytest.mark.table(
    ("url", "local", "remote"),
    [
        ("udp://:14540@127.0.0.1:14580", ("127.0.0.1", 14540), ("127.0.0.1", 14580)),
        ("udp://:14540@localhost:14580/", ("127.0.0.1", 14540), ("127.0.0.1", 14580)),
        ("udp://0.0.0.0:14540@127.0.0.1:14580", ("0.0.0.0", 14540), ("127.0.0.1", 14580)),
        ("udp://127.0.0.3:0@127.0.0.2:14580", ("127.0.0.3", 0), ("127.0.0.2", 14580)),
    ],
)
def test_a_url_names_both_ends_without_a_host_on_the_loopback(url, local, remote):
    assert parse_fcu_url(url) == Endpoints(local, remote)


@pytest.mark.table(
    "bad", ["tcp://localhost:5760", "udp://:14540@", "udp://:99999@127.0.0.1:1", "", "udp://a:b@c:d"]
)
def test_what_is_no_url_is_refused_in_a_sentence(bad):
    with pytest.raises(LinkError, match=r"Cannot read the fcu_url .*such as udp://:14540@127.0.0.1:14580"):
        parse_fcu_url(bad)


def test_a_host_that_nobody_knows_is_named():
    with pytest.raises(LinkError, match=r"Cannot find the host 'no-such-drone.invalid'.*check its name"):
        parse_fcu_url("udp://:14540@no-such-drone.invalid:14580")
