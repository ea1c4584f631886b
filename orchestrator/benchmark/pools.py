"""Where the episodes of a sweep run: in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import ctypes
import logging
import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, as_completed
from typing import Any

from pebble import ProcessExpired, ProcessPool

from orchestrator.benchmark.plan import Task
from orchestrator.benchmark.worker import Outcome, failure, run
from orchestrator.errors import InputError, RunError

_PR_SET_PDEATHSIG = 1


def local(tasks: Sequence[Task], workers: int, timeout: float) -> Iterator[tuple[Task, Outcome]]:
    """Run the tasks in `workers` processes; yields each with its outcome as it comes.

    A worker that dies, or an episode that takes longer than `timeout` [s], is a failure of that episode alone.
    """
    context = multiprocessing.get_context("spawn")
    pool = ProcessPool(max_workers=workers, context=context, initializer=_begin_worker, initargs=(os.getpid(),))
    try:
        futures: dict[Future[Any], Task] = {pool.schedule(run, args=(t,), timeout=timeout): t for t in tasks}
        for future in as_completed(futures):
            yield futures[future], _outcome(future, timeout)
        pool.close()
    finally:
        pool.stop()  # does nothing to a pool that is closed
        pool.join()


def _outcome(future: Future[Any], timeout: float) -> Outcome:
    try:
        outcome: Outcome = future.result()
    except TimeoutError:
        return failure(f"took longer than {timeout:g} s of wall-clock time (--timeout) and was ended")
    except ProcessExpired as error:
        return failure(f"its worker died with exit code {error.exitcode}")
    except Exception as error:
        return failure(f"{type(error).__name__}: {error}")
    return outcome


def _begin_worker(parent: int) -> None:
    """Leave Ctrl-C to the sweep, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def cluster(tasks: Sequence[Task], address: str) -> Iterator[tuple[Task, Outcome]]:
    """Run the tasks on the Dask cluster whose scheduler listens at `address`; yields each with its outcome.

    Raises:
        InputError: if `distributed` is not installed, or nobody answers.
        RunError: if the scheduler is lost.
    """
    try:
        from distributed import Client
        from distributed import as_completed as completed
    except ImportError:
        raise InputError("--cluster needs the package distributed: pip install 'crowdcosim[cluster]'") from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what is lost is said in one line, below
    try:
        client = Client(address, timeout="15s", set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(f"no Dask scheduler answers at {address}: {error}") from None
    try:
        if not client.scheduler_info()["workers"]:
            raise InputError(f"the scheduler at {address} has no workers; start some: dask worker {address}")
        futures = {client.submit(run, task, key=f"crowdcosim {task.key}", pure=False): task for task in tasks}
        for future in completed(list(futures), loop=client.loop):
            if future.cancelled():
                raise RunError(None, None, f"the scheduler at {address} was lost; the same command resumes the sweep")
            yield futures[future], failure(str(future.exception())) if future.exception() else future.result()
    finally:
        client.close()
