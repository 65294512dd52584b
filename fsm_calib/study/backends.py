"""Where the robots of a fleet run: local processes or threads, or an existing Dask or Ray cluster, by joblib.

Every worker uses one thread of linear algebra, so that results do not depend on the machine's number of
cores, and so that cores are shared out among robots.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Literal

import joblib
from threadpoolctl import threadpool_limits

from fsm_calib.errors import InputError, MissingExtraError

Backend = Literal["loky", "threading", "dask", "ray"]
BACKENDS: tuple[Backend, ...] = ("loky", "threading", "dask", "ray")
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""What the libraries read when a worker starts."""
EXTRA_OF = {"dask": ("distributed", "cluster"), "ray": ("ray", "ray")}
"""Package and extra of each cluster."""
CONNECT_SECONDS = 20
"""How long to wait for a cluster's answer [s]."""
ROUND = 4
"""Calls for each worker in one list, where a back end hands back whole lists [1]."""
SENT_AHEAD = 2
"""Calls that wait at the workers [1]: few, so that a command that is killed leaves little behind."""


@dataclass(frozen=True, slots=True)
class Crew:
    """Who does the work: back end, robots at a time (None: all cores or workers), address of the cluster."""

    backend: Backend = "loky"
    jobs: int | None = None
    address: str | None = None


def crew_of(backend: str, jobs: int | None, address: str | None) -> Crew:
    """Return who does the work, as the options of a command say it; refuse what cannot work (`check_backend`).

    Raises
    ------
    InputError
        For a back end that there is not, too.
    """
    chosen = next((name for name in BACKENDS if name == backend), None)
    if chosen is None:
        cure = f"Give one of {', '.join(BACKENDS)}."
        raise InputError(f"there is no back end {backend!r}", where="--backend", cure=cure)
    check_backend(chosen, address, jobs)
    return Crew(chosen, jobs, address)


def local_cores() -> int:
    """Return how many cores this process may use."""
    return joblib.cpu_count()


def check_backend(backend: Backend, address: str | None, jobs: int | None) -> None:
    """Refuse what cannot work, before anything is written.

    Raises
    ------
    InputError
        For an address without a cluster, or a number of jobs below one.
    MissingExtraError
        When the cluster's package is not installed.
    """
    if jobs is not None and jobs < 1:
        raise InputError(f"--jobs is {jobs}", where="--jobs", cure="Give 1 or more, or leave it out.")
    if backend not in EXTRA_OF:
        if address is not None:
            cure = "Add --backend dask or --backend ray, or leave the address out."
            raise InputError(f"the back end {backend} has no address", where="--address", cure=cure)
        return
    package, extra = EXTRA_OF[backend]
    try:
        import_module(package)
    except ImportError as error:
        raise MissingExtraError(package, extra) from error


@contextmanager
def workers(backend: Backend, jobs: int | None, address: str | None) -> Iterator[int]:
    """Choose where calls of `results_of` run inside the `with` block; yield how many run at a time.

    Parameters
    ----------
    backend : {"loky", "threading", "dask", "ray"}
    jobs : int or None
        Robots at a time; by default all local cores, or all workers of the cluster.
    address : str or None
        Of the cluster's scheduler; by default Dask and Ray start one on this machine.
    """
    check_backend(backend, address, jobs)
    with ExitStack() as stack:
        for variable in THREAD_VARIABLES:
            os.environ.setdefault(variable, "1")  # inherited by the processes that are started
        stack.enter_context(threadpool_limits(1))
        if backend == "dask":
            found = stack.enter_context(_dask(address, jobs))
        elif backend == "ray":
            found = stack.enter_context(_ray(address, jobs))
        else:
            found = local_cores()
        count = jobs or found
        stack.enter_context(joblib.parallel_config(backend, n_jobs=-1 if backend in EXTRA_OF else count))
        yield count


def results_of(function: Callable[..., Any], calls: Sequence[tuple[Any, ...]], count: int) -> Iterator[Any]:
    """Yield ``function(*call)`` of each call, as they come, in any order.

    Parameters
    ----------
    function : callable
        Importable by the workers.
    calls : sequence of tuple
        Arguments of each call.
    count : int
        Calls at a time; one runs in this process where the back end is a local one. A few more are sent
        ahead, so that no worker waits.
    """
    delayed = [joblib.delayed(function)(*call) for call in calls]
    if _hands_back_at_once():
        pool = joblib.Parallel(
            n_jobs=count, return_as="generator_unordered", batch_size=1, pre_dispatch=count + SENT_AHEAD
        )
        yield from pool(delayed)
        return
    for first in range(0, len(delayed), ROUND * count):
        yield from joblib.Parallel(n_jobs=count, batch_size=1)(delayed[first : first + ROUND * count])


def _hands_back_at_once() -> bool:
    """Tell whether the back end in use hands back each result as it comes (Ray's hands back whole lists)."""
    backend, _ = joblib.parallel.get_active_backend()
    return bool(backend.supports_return_generator)


def death_errors(backend: Backend) -> tuple[type[BaseException], ...]:
    """Return what is raised when a worker's process has died with a robot in its hands."""
    if backend == "dask":
        from distributed.scheduler import KilledWorker

        return (KilledWorker,)
    if backend == "ray":
        from ray.exceptions import RayActorError, WorkerCrashedError

        return (RayActorError, WorkerCrashedError)
    return (BrokenExecutor,)


def end_local_workers() -> None:
    """End the local worker processes at once; what they were doing stays on disk up to the last event."""
    from joblib.externals.loky import get_reusable_executor

    get_reusable_executor().shutdown(wait=True, kill_workers=True)


@contextmanager
def _dask(address: str | None, jobs: int | None) -> Iterator[int]:
    """Connect to a Dask cluster; without an address, start one of processes with one thread each."""
    from distributed import Client

    local = {"n_workers": jobs or local_cores(), "threads_per_worker": 1, "dashboard_address": None}
    try:
        client = Client(address, timeout=CONNECT_SECONDS) if address else Client(**local)
        client.wait_for_workers(1, timeout=CONNECT_SECONDS)
    except (OSError, ValueError) as error:  # a time-out is an OSError
        cure = "Start one with: dask scheduler, and give its address: tcp://HOST:8786."
        raise InputError(f"no Dask cluster answers ({error})", where="--address", cure=cure) from error
    with client:
        yield sum(client.nthreads().values())


@contextmanager
def _ray(address: str | None, jobs: int | None) -> Iterator[int]:
    """Connect to a Ray cluster; without an address, start one on this machine."""
    import ray
    from ray.util.joblib import register_ray

    local = {} if address else {"num_cpus": jobs or local_cores(), "include_dashboard": False}
    try:
        ray.init(address=address, log_to_driver=False, **local)
    except (ConnectionError, ValueError) as error:
        cure = "Start one with: ray start --head, and give its address."
        raise InputError(f"no Ray cluster answers ({error})", where="--address", cure=cure) from error
    try:
        register_ray()
        yield int(ray.cluster_resources().get("CPU", 1))
    finally:
        ray.shutdown()
