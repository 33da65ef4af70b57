"""The message subsets are upstream's to the bit: equal md5sums let any upstream client interoperate."""

from __future__ import annotations

import importlib

import pytest

from doctor.upstream_messages import UPSTREAM_MD5SUMS as UPSTREAM

pytestmark = pytest.mark.ros


def test_md5sums_are_upstreams():
    assert {name: interface(name)._md5sum for name in UPSTREAM} == UPSTREAM


def test_every_interface_of_ours_is_compared(request):
    sources = request.config.rootpath.glob("src/interfaces/*/*/*.[ms][sr][gv]")
    assert {f"{path.parts[-3]}/{path.stem}" for path in sources} == set(UPSTREAM)


def interface(name):
    package, type_name = name.split("/")
    for kind in ("msg", "srv"):
        found = getattr(importlib.import_module(f"{package}.{kind}"), type_name, None)
        if found is not None:
            return found
        if package in ("geographic_msgs", "trajectory_msgs"):  # have no services
            break
    raise LookupError(f"{name} is not built")
