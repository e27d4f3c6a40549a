"""The same bits on real engines, whatever happens to their workers; loopback alone is used."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from on_engine import RUNS, WORKS, digest, runs_of, wait_until
from on_engine import main as on_one_thread

PROGRAM = Path(__file__).with_name("on_engine.py")
MPI = ["mpiexec", "--allow-run-as-root", "--oversubscribe", "-n", "3", sys.executable, "-m"]
# Processes of one machine speak by memory; what is left of sockets keeps to the loopback.
LOOPBACK = {"OMPI_MCA_btl": "^tcp", "OMPI_MCA_oob_tcp_if_include": "lo"}
#: [s] after which a program is taken to hang.
DEADLINE = 90
ENGINES = ["pool", "loky", "dask", "mpi"]


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """What one thread gives, by the names of the works."""
    folder = tmp_path_factory.mktemp("one")
    on_one_thread("one", ",".join(WORKS), folder)
    return {work: json.loads((folder / f"{work}.json").read_text()) for work in WORKS}


def start(engine, works, folder, way=""):
    words = [str(PROGRAM), engine, works, str(folder), *([way] if way else [])]
    before = [*MPI, "mpi4py.futures"] if engine == "mpi" else [sys.executable, "-W", "error"]
    if way.startswith("kill") and engine != "mpi":
        before = [sys.executable]  # a warning tells of the dead process
    environment = {**os.environ, **LOOPBACK}
    return subprocess.Popen(
        [*before, *words],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def ended(process, code=0):
    """Wait for a program's end, and give what it wrote."""
    try:
        out, error = process.communicate(timeout=DEADLINE)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        out, error = process.communicate()
        pytest.fail(f"the program hangs:\n{out}{error}")
    assert process.returncode == code, error
    return error


def found(work, folder):
    return json.loads((folder / f"{work}.json").read_text())


@pytest.mark.parametrize("engine", ENGINES)
def test_every_work_has_the_bits_of_one_thread(engine, expected, tmp_path):
    ended(start(engine, ",".join(WORKS), tmp_path))
    assert {work: found(work, tmp_path)["bits"] for work in WORKS} == {
        work: one["bits"] for work, one in expected.items()
    }
    processes = {int(path.name.split()[1]) for path in tmp_path.glob("pid *")}
    main = int((tmp_path / "main").read_text())
    assert len(processes - {main}) == 2  # Bowl tells the main one of the best point, once


@pytest.mark.parametrize("engine", ["pool", "loky", "dask"])
def test_a_worker_that_is_killed_in_the_midst_of_a_block(engine, expected, tmp_path):
    error = ended(start(engine, "bfoa", tmp_path, "kill-self"))
    assert (tmp_path / "killed").exists()
    assert found("bfoa", tmp_path) == expected["bfoa"]
    assert engine == "dask" or "a process of a" in error


@pytest.mark.parametrize("engine", ["pool", "loky", "dask"])
def test_a_worker_that_is_killed_during_a_monte_carlo_analysis(engine, expected, tmp_path):
    ended(start(engine, "monte_carlo", tmp_path, "kill-from-outside"))
    assert found("monte_carlo", tmp_path) == expected["monte_carlo"]


def test_mpi_ends_with_a_dead_rank_and_the_checkpoint_goes_on(expected, tmp_path):
    """MPI itself ends every rank then: what is done is in the checkpoint."""
    process = start("mpi", "monte_carlo", tmp_path, "kill-from-outside")
    process.communicate(timeout=DEADLINE)
    assert process.returncode != 0
    assert not (tmp_path / "monte_carlo.json").exists()
    assert (tmp_path / "runs").exists()
    ended(start("mpi", "monte_carlo", tmp_path))
    assert found("monte_carlo", tmp_path) == expected["monte_carlo"]


@pytest.mark.parametrize("engine", ENGINES)
def test_ctrl_c_ends_a_search_with_the_best_so_far(engine, tmp_path):
    process = start(engine, "bfoa", tmp_path, "wait")
    try:
        wait_until(lambda: (tmp_path / "waiting").exists() or process.poll() is not None)
        os.kill(int((tmp_path / "main").read_text()), signal.SIGINT)
        wait_until(lambda: (tmp_path / "bfoa.json").exists() or process.poll() is not None)
    finally:
        (tmp_path / "released").touch()
    ended(process)
    result = found("bfoa", tmp_path)
    assert result["message"] == "The search was interrupted; this is the best so far."
    assert result["fun"] == result["own"]


@pytest.mark.parametrize("engine", ENGINES)
def test_ctrl_c_keeps_the_runs_that_are_done(engine, tmp_path):
    ended(start(engine, "monte_carlo", tmp_path, "interrupt"))
    kept = found("monte_carlo", tmp_path)
    assert 0 < kept["count"] < RUNS
    assert kept["bits"] == digest(runs_of(kept["count"]).costs)


REFUSED = """
import nfopidn
from dask.distributed import Client, LocalCluster
def says(workers):
    try:
        nfopidn.bfoa(max, [(0, 1)], workers=workers)
    except ValueError as error:
        print(error)
if __name__ == "__main__":
    with LocalCluster(
        n_workers=0, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as cluster, Client(cluster) as client:
        says(cluster)
        client.close()
        says(client)
"""


def test_what_is_no_cluster_s_client_is_refused(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(REFUSED)
    done = subprocess.run(
        [sys.executable, str(program)], check=True, capture_output=True, text=True, timeout=DEADLINE
    )
    cluster, closed = done.stdout.splitlines()
    assert "LocalCluster" in cluster
    assert cluster.endswith("(of a Dask cluster, its client: dask.distributed.Client(cluster))")
    assert closed == "workers is a dask.distributed.Client that is closed; must be open"
