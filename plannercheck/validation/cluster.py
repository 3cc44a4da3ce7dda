"""Chunks judged on a dask.distributed cluster, here or elsewhere.

In: a checker, a `Judge`, the address of a scheduler or a number of processes. Out: findings, as they come in.

Each worker gets the checker once, with its prepared bodies, as a plugin; workers that join later or restart get it as
well. The rows go with the task, so the scheduler can give a lost worker's chunks to another one. Only a few chunks for
each worker are in memory at a time.

Whoever reaches a scheduler can run code on its workers. So a cluster that is started here listens on the loopback only,
requires a certificate that this run makes and keeps in memory, and serves no pages.
"""

from __future__ import annotations

import logging
import pickle
import signal
import threading
import uuid
from collections.abc import Iterable, Iterator
from types import TracebackType
from typing import Any

from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.optional_imports import extra_module
from plannercheck.common.version import __version__
from plannercheck.validation.engines import evaluate
from plannercheck.validation.formats.chunks import Chunk
from plannercheck.validation.judging import Findings, Judge

distributed: Any = extra_module("distributed", "dask", "clusters")
dask_system: Any = extra_module("dask.system", "dask", "clusters")

# Chunks for each thread of a worker: one that is judged, and one in transit.
_AHEAD = 2

# How often a chunk is tried again after an error, and how long to wait for a scheduler or the first worker, s.
_RETRIES, _PATIENCE = 3, 30

# Where a cluster of this machine listens.
_LOOPBACK = "127.0.0.1"


class _ServesNoPages:
    """A node of dask without an HTTP server, which each node would open, whatever the settings of dashboards."""

    def start_http_server(self, *arguments: Any, **options: Any) -> None:
        """Called by distributed where a node starts."""


class LocalScheduler(_ServesNoPages, distributed.Scheduler):  # type: ignore[misc]  # that library is optional
    """The scheduler of a cluster of this machine."""


class LocalWorker(_ServesNoPages, distributed.Worker):  # type: ignore[misc]  # that library is optional
    """A worker of such a cluster; public, since child processes import it by name."""


class CheckerOnWorker(distributed.WorkerPlugin):  # type: ignore[misc]  # that library is optional
    """The plugin of a worker: the checker, unpacked when the worker gets it."""

    def __init__(self, name: str, packed: bytes, judge: Judge, is_child: bool) -> None:
        self.name, self._packed, self._judge, self._is_child = name, packed, judge, is_child
        self._version = __version__
        self._checker: AnyChecker | None = None

    def setup(self, worker: Any) -> None:
        """Called by distributed on the worker."""
        if self._version != __version__:
            raise PlannercheckError(f"the worker has plannercheck {__version__}, the run {self._version}")
        self._checker = pickle.loads(self._packed)
        if self._is_child and threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches it, too, but its parent ends it in order

    def teardown(self, worker: Any) -> None:
        """Called when the worker or its plugin goes."""
        self._checker = None

    def evaluate(self, chunk: Chunk) -> Findings:
        """What is found about a chunk."""
        assert self._checker is not None  # a worker works only after its setup
        return evaluate(self._judge, self._checker, chunk)


def judged_on_worker(plugin: str, chunk: Chunk) -> Findings:
    """The task: judges a chunk with the checker of the worker that runs it."""
    held: CheckerOnWorker = distributed.get_worker().plugins[plugin]
    return held.evaluate(chunk)


class ClusterEngine:
    """Judges on a cluster; to be used in a `with` statement."""

    def __init__(
        self,
        checker: AnyChecker,
        judge: Judge,
        scheduler: str | None = None,
        workers: int | None = None,
        security: Any = None,
    ) -> None:
        """Connects, or starts processes here, and sends the checker.

        Args:
            checker: The checker.
            judge: The questions about each chunk.
            scheduler: Address of a scheduler, e.g. "tcp://10.0.0.1:8786"; None starts a cluster on this machine.
            workers: Processes of such a cluster.
            security: distributed.Security for a given scheduler; None takes what dask's own configuration says.

        Raises:
            PlannercheckError: If there is no such scheduler, or a worker can't take the checker.
            RuntimeError: If no cluster starts on this machine.
        """
        self._cluster = _started(workers) if scheduler is None else None
        try:
            self.client = self._connected(scheduler, security)
            self._plugin = f"plannercheck-{uuid.uuid4().hex}"
            self._send(CheckerOnWorker(self._plugin, pickle.dumps(checker), judge, self._cluster is not None))
        except BaseException:
            self.close()
            raise

    def _connected(self, scheduler: str | None, security: Any) -> Any:
        try:
            client = distributed.Client(
                self._cluster or scheduler, timeout=_PATIENCE, set_as_default=False, security=security
            )
            client.wait_for_workers(1, timeout=_PATIENCE)
        except (OSError, TimeoutError, ValueError, RuntimeError) as error:
            if scheduler is None:
                raise _not_started(error) from None
            raise PlannercheckError(
                f"no cluster at {scheduler}: {error}; --scheduler takes the address that "
                "`dask scheduler` prints, and `dask worker ADDRESS` adds a worker"
            ) from None
        return client

    def _send(self, plugin: CheckerOnWorker) -> None:
        try:
            self.client.register_plugin(plugin, name=plugin.name)
        except Exception as error:  # whatever a worker raises comes back as it is
            raise PlannercheckError(
                f"a worker can't take the checker: {type(error).__name__}: {error}; workers need the same plannercheck "
                "and Python as this machine"
            ) from None

    def findings(self, chunks: Iterable[Chunk]) -> Iterator[tuple[Chunk, Findings]]:
        """What is found about each chunk, as it comes in."""
        source = iter(chunks)
        under_way: dict[Any, Chunk] = {}
        done = distributed.as_completed(loop=self.client.loop)
        while True:
            for chunk in self._more(source, len(under_way)):
                future = self._submitted(chunk)
                under_way[future] = chunk
                done.add(future)
            if not under_way:
                return
            future = next(done)
            yield under_way.pop(future), self._result(future)

    def _more(self, source: Iterator[Chunk], under_way: int) -> Iterator[Chunk]:
        wanted = _AHEAD * max(1, sum(self.client.nthreads().values()))
        for _ in range(wanted - under_way):
            chunk = next(source, None)
            if chunk is None:
                return
            yield chunk

    def _submitted(self, chunk: Chunk) -> Any:
        name = f"judged-{chunk.file}-{chunk.first_row}-{uuid.uuid4().hex}"
        return self.client.submit(judged_on_worker, self._plugin, chunk, key=name, pure=False, retries=_RETRIES)

    def _result(self, future: Any) -> Findings:
        try:
            return future.result()  # type: ignore[no-any-return]
        except PlannercheckError:
            raise
        except Exception as error:  # nothing that was given is at fault
            raise RuntimeError(
                f"the cluster could not judge a chunk, tried {_RETRIES + 1} times: {type(error).__name__}: {error}"
            ) from None

    def close(self) -> None:
        """Leaves the cluster; one that was started here ends."""
        client = getattr(self, "client", None)
        if client is not None:
            if hasattr(self, "_plugin"):
                _quietly(lambda: client.unregister_worker_plugin(self._plugin))
            client.close()
        if self._cluster is not None:
            self._cluster.close()

    def __enter__(self) -> ClusterEngine:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _started(workers: int | None) -> Any:
    """A cluster of processes on this machine, which only this process can talk to."""
    shared = {"host": _LOOPBACK, "protocol": "tls://", "security": _certificate()}
    scheduler = {"cls": LocalScheduler, "options": {**shared, "port": 0, "dashboard": False}}
    worker = {
        "cls": distributed.Nanny,
        "options": {**shared, "worker_class": LocalWorker, "nthreads": 1, "silence_logs": logging.WARNING},
    }
    count = workers or dask_system.CPU_COUNT
    try:
        return distributed.SpecCluster(
            workers=dict.fromkeys(range(count), worker),
            scheduler=scheduler,
            security=shared["security"],
            silence_logs=logging.WARNING,
        )
    except Exception as error:  # whatever a worker dies of
        raise _not_started(error) from None


def _certificate() -> Any:
    """Keys and a certificate that live in the memory of this run's processes."""
    try:
        return distributed.Security.temporary()
    except ImportError:
        raise PlannercheckError(
            "a cluster on this machine needs the package cryptography: pip install 'plannercheck[dask]'"
        ) from None


def _not_started(error: Exception) -> RuntimeError:
    return RuntimeError(f"the cluster on this machine did not start: {type(error).__name__}: {error}")


def _quietly(call: Any) -> None:
    try:
        call()
    except Exception:  # a cluster that is gone has nothing to forget
        return
