"""Processes of Dask that run trials, on this machine or on a cluster."""

from __future__ import annotations

import asyncio
import contextlib
import importlib.util
import logging
import os
import signal
import sys
import tempfile
import uuid
from pathlib import Path
from typing import Any, Callable, Iterator, Sequence, TypeVar

import dask
from distributed import Client, LocalCluster, as_completed

from flights.errors import TrialsError
from mesh_files.scratch import scratch_folder

Task = TypeVar("Task")
Result = TypeVar("Result")

ALLOWED_FAILURES = 10
"""After this many dead workers a trial is given up."""
PACKAGE = "flights"
"""What a worker must be able to import."""
CONNECT_TIMEOUT_S = 15
CLOSE_TIMEOUT_S = 1
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
_SETTINGS = {
    "distributed.nanny.pre-spawn-environ": {**ONE_THREAD, "NUMBA_NUM_THREADS": "1"},
    "distributed.scheduler.allowed-failures": ALLOWED_FAILURES,
    "distributed.comm.timeouts.connect": f"{CONNECT_TIMEOUT_S}s",
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
}


class DaskWorkers:
    """Processes of a local cluster, or those of a scheduler; use it as a context manager."""

    def __init__(self, number: int | None = None, scheduler: str | None = None) -> None:
        """number: of local processes; default: as many as cores. scheduler: tcp://host:port, or its file.

        Raises:
            TrialsError: the scheduler cannot be reached, or one of its workers lacks this workspace.
        """
        self._cluster: LocalCluster | None = None
        self._scratch = scratch_folder("flights_workers")  # a worker that is killed leaves its files
        # "pre-spawn-environ" stays in the environment of this process: no folder that ends with the workers.
        own = {"distributed.nanny.environ": {"TMPDIR": self._scratch.name}}
        self._settings = dask.config.set({**_SETTINGS, **own})
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # `run_trials` reports dead workers
        if scheduler is not None:
            self._client = _connected(scheduler)
            _check_workers(self._client, scheduler)
            return
        self._cluster = LocalCluster(
            n_workers=number or os.cpu_count(),
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            memory_limit=0,
            silence_logs=logging.CRITICAL,
            preload=[__name__],
        )
        self._client = Client(self._cluster)

    @property
    def address(self) -> str:
        """The scheduler's."""
        return str(self._client.scheduler_info()["address"])

    @property
    def pids(self) -> list[int]:
        """Process ids of the local cluster's workers."""
        nannies = self._cluster.workers.values() if self._cluster else ()
        return [nanny.pid for nanny in nannies if nanny.pid is not None]

    def results(
        self, run: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[Task, Result | Exception]]:
        """Run tasks and yield each with its result when it is finished.

        If a worker dies, another one runs its task again. After too many deaths the result is the exception.

        Raises:
            TrialsError: the scheduler is gone.
        """
        run_id = uuid.uuid4().hex
        tasks_by_key = {f"trial-{run_id}-{number}": task for number, task in enumerate(tasks)}
        futures = [self._client.submit(run, task, key=key) for key, task in tasks_by_key.items()]
        finished = as_completed(futures, with_results=True, raise_errors=False)
        del futures  # Dask may forget finished tasks
        for future, result in finished:
            if future.status in ("cancelled", "lost"):
                raise TrialsError("The scheduler is gone; call again to go on with what is missing.")
            yield tasks_by_key[future.key], result[1] if future.status == "error" else result

    def kill(self) -> None:
        """End local processes at once, and remove their temporary files.

        Those of a cluster only stop working for this process.
        """
        if self._cluster is None:
            return
        for nanny in self._cluster.workers.values():
            nanny.auto_restart = False
        for pid in self.pids:
            with contextlib.suppress(ProcessLookupError):  # it has ended already
                os.kill(pid, signal.SIGKILL)
        self._scratch.cleanup()

    def close(self) -> None:
        """Leave the scheduler; end the local cluster."""
        self.kill()
        for one in (self._client, self._cluster):
            if one is not None:
                with contextlib.suppress(asyncio.TimeoutError, TimeoutError):  # one class since Python 3.11
                    one.close(timeout=CLOSE_TIMEOUT_S)
        self._settings.__exit__(None, None, None)
        self._scratch.cleanup()

    def __enter__(self) -> DaskWorkers:
        return self

    def __exit__(self, kind: type[BaseException] | None, *exception: object) -> None:
        if kind is KeyboardInterrupt:
            self.kill()  # closing would take seconds
        else:
            self.close()


def dask_setup(worker: Any) -> None:
    """Prepare a worker: the main process handles Ctrl-C; TMPDIR is read anew. Dask calls this (`preload`)."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    tempfile.tempdir = None


def _connected(scheduler: str) -> Client:
    file = Path(scheduler).expanduser()
    try:
        if "://" in scheduler:
            return Client(scheduler, timeout=CONNECT_TIMEOUT_S)
        if not file.is_file():
            raise TrialsError(
                f"There is no scheduler file {file}; give tcp://host:port, or the file of `dask scheduler "
                "--scheduler-file FILE`."
            )
        return Client(scheduler_file=str(file), timeout=CONNECT_TIMEOUT_S)
    except (OSError, ValueError) as error:
        raise TrialsError(f"The scheduler {scheduler} cannot be reached: {error}.") from None


def _check_workers(client: Client, scheduler: str) -> None:
    """Refuse workers without the package: each would end at its first trial, and tell only its terminal."""
    found = client.run(importlib.util.find_spec, PACKAGE)
    if not found:
        print(f"No worker has joined {scheduler} yet; the trials wait for one.", file=sys.stderr)
    lacking = sorted(address for address, module in found.items() if module is None)
    if lacking:
        client.close(timeout=CLOSE_TIMEOUT_S)
        raise TrialsError(
            f"Workers that cannot import {PACKAGE}: {', '.join(lacking)}. Stop them, and start each "
            "again after `source devel/setup.bash` in the workspace of its machine."
        )
