"""How much memory a piece of a program takes at its peak."""

from __future__ import annotations

from pathlib import Path


class PeakMemory:
    """Measures by how much this process grows inside a `with`, at its peak; Linux only, else None."""

    def __init__(self) -> None:
        self.peak_mb: float | None = None
        self._before_mb: float | None = None

    def __enter__(self) -> PeakMemory:
        try:
            Path("/proc/self/clear_refs").write_text("5", encoding="ascii")  # the peak begins anew
            self._before_mb = _status_mb("VmRSS")
        except OSError:
            self._before_mb = None
        return self

    def __exit__(self, *exception) -> None:
        if self._before_mb is not None:
            self.peak_mb = _status_mb("VmHWM") - self._before_mb


def _status_mb(key: str) -> float:
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith(key))
