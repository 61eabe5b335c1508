"""Linear algebra in one thread: for matrices of some ten columns several threads only wait for each other."""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
T = TypeVar("T")


def in_one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Return the function, limited to one thread of BLAS while it runs.

    Examples
    --------
    >>> from threadpoolctl import threadpool_info
    >>> @in_one_thread
    ... def threads():
    ...     return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}
    >>> threads()
    {1}
    """

    @functools.wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> T:
        with one_thread():
            return function(*args, **kwargs)

    return limited


@contextmanager
def one_thread(*modules: str) -> Iterator[None]:
    """Limit linear algebra to one thread; the former limits are restored at the end.

    ``modules`` are imported first: a library that is loaded later would not be limited.
    """
    with _pools(*modules).limit(limits=1):
        yield


@functools.cache
def _pools(*modules: str) -> ThreadpoolController:
    """Return the thread pools of numpy, scipy and further modules. To look for them takes milliseconds."""
    from threadpoolctl import ThreadpoolController

    # The BLAS of scipy is another one than that of numpy.
    for name in ("scipy.linalg", *modules):
        importlib.import_module(name)
    return ThreadpoolController()
