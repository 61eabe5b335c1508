"""Linear algebra in one thread: for matrices of some ten columns several threads only wait for each other."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
T = TypeVar("T")


def in_one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Return the function, with the threads of BLAS held while it runs; they are set back afterwards.

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
    def held(*args: P.args, **kwargs: P.kwargs) -> T:
        with _pools().limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return held


@functools.cache
def _pools() -> ThreadpoolController:
    """Return the thread pools of numpy and scipy. To look for them takes milliseconds."""
    import scipy.linalg  # noqa: F401  its BLAS is another one than numpy's
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
