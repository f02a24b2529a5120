"""Child processes with one pipe each; none outlives the block that started them."""

from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

__all__ = ["Children", "killed_at_the_end"]

Children = tuple[list[BaseProcess], list[Connection]]
"""Processes, and this process's ends of their pipes."""


@contextmanager
def killed_at_the_end() -> Iterator[Children]:
    """Yield two empty lists to be filled; kill the processes and close the pipes when the block
    ends.
    """
    processes: list[BaseProcess] = []
    pipes: list[Connection] = []
    try:
        yield processes, pipes
    finally:
        for process in processes:
            process.kill()
        for process in processes:
            process.join()
        for pipe in pipes:
            pipe.close()
