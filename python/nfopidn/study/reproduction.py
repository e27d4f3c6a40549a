"""The whole study: every table and figure of the paper, and what it leaves open."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from nfopidn.arguments import whole_number
from nfopidn.console import progress as progress_bar
from nfopidn.engines import read_workers
from nfopidn.study.cases import MEMORIES, Cases
from nfopidn.study.files import make_folder
from nfopidn.study.transcription import casadi

_OTHER_STEPS = 10  # beside the searches


def reproduce(
    directory: str | os.PathLike[str], *, seeds: int = 25, workers: Any = 1, progress: bool = False
) -> list[Path]:
    """Write the paper's tables and figures, and the studies beside them, into a folder.

    Every figure is there as PNG and SVG, every table as CSV and JSON; README.md lists them. The
    same seeds give the same numbers.

    Parameters
    ----------
    directory
        made if it does not exist; files of the same names are replaced
    seeds
        searches for each memory, with the seeds 1 to `seeds`
    workers
        of the searches for each memory: threads, -1 for as many as there are processors; or an
        Executor as of concurrent.futures, a dask.distributed.Client or a function like map. The
        files are the same with each.
    progress
        show a bar

    Returns
    -------
    list of Path
        the files

    Raises
    ------
    ValueError
        If `seeds` is no whole number of at least 1, `workers` is out of range, or the folder has a
        README.md that is not of a study.
    ImportError
        If CasADi is not installed.
    OSError
        If a file cannot be written.
    InterruptedSearchError
        After Ctrl-C; what is written by then stays.
    """
    whole_number("seeds", seeds, 1)
    crew = read_workers(workers)
    casadi()
    from nfopidn.study import claims, memory, optima, poses, readings, runs

    folder = make_folder(directory)
    total = len(MEMORIES) * seeds + _OTHER_STEPS
    with progress_bar("study", total, progress) as report:
        done = iter(range(1, total + 1))
        cases = Cases(lambda note: report(next(done), note))
        for part in (
            runs.gain_tables,
            runs.z_plane,
            runs.run_figures,
            claims.claims,
            claims.steady_state,
            readings.readings,
            poses.pose_study,
            optima.optima,
        ):
            part(cases, folder)
        memory.memory_study(cases, folder, seeds, crew)
    folder.index("The paper's tables and figures, and the studies beside them")
    return folder.written()
