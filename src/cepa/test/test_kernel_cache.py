"""What numba compiled from older sources does no harm."""

from numba.core.caching import IndexDataCacheFile

from cepa.kernels import surroundings


def test_code_for_a_tuple_that_is_gone_is_compiled_anew(tmp_path, monkeypatch):
    file = IndexDataCacheFile(str(tmp_path), "kernel", "stamp")
    gone = type("Gone", (), {"__module__": surroundings.__name__})
    with monkeypatch.context() as older:
        older.setattr(surroundings, "Gone", gone, raising=False)
        file.save(gone, "code for what is gone")
        assert file.load(gone) == "code for what is gone"
    assert file.load("int") is None
    file.save("int", "code for int")
    assert file.load("int") == "code for int"
