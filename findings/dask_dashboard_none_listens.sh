#!/usr/bin/env bash
# Dask: a cluster without a dashboard serves one's port all the same.
#
# One would guess: LocalCluster(dashboard_address=None), which is documented to disable the dashboard, opens no port for
#   it: a second such cluster beside it is as good as the first.
# What happens: the scheduler listens on port 8787 of the cluster's host with either. The second cluster finds it taken
#   and warns "Port 8787 is already in use", which ends a program that runs with -W error; so do tests that run at the
#   same time. "" in place of None is worse: the port is then open on all interfaces, host="127.0.0.1" or not. A port of
#   its own, dashboard_address="127.0.0.1:0", makes no noise.
# Why it matters: tests of two clusters at a time fail now and then, and a machine that is to have no open port has one.
# Seen with: dask and distributed 2026.8.0.
# Source: LocalCluster's own docstring ("Set to None to disable the dashboard");
#   https://github.com/dask/distributed/issues/7207, open since 2022.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check dask==2026.8.0 distributed==2026.8.0 psutil==7.2.2

cat > ports.py <<'PYTHON'
import warnings

import psutil
from dask.distributed import LocalCluster


def cluster(address):
    return LocalCluster(n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address=address)


def listening():
    """Return the addresses of the scheduler, which runs in this process."""
    return sorted(tuple(one.laddr) for one in psutil.Process().net_connections("tcp") if one.status == "LISTEN")


def told(address):
    """Return addresses of one cluster, and what a second one beside it warns of."""
    with warnings.catch_warnings(record=True) as caught, cluster(address):
        warnings.simplefilter("always")
        first = listening()
        with cluster(address):
            pass
    texts = [str(one.message).splitlines()[0] for one in caught]
    print(f"  dashboard_address={address!r}: listens on {first}; a second one warns: {texts}")
    return first, [text for text in texts if "8787 is already in use" in text]


if __name__ == "__main__":
    none, own, empty = told(None), told("127.0.0.1:0"), told("")
    assert ("127.0.0.1", 8787) in none[0] and none[1], "None no longer opens the dashboard's port"
    assert not own[1], "a port of its own warns too"
    assert ("0.0.0.0", 8787) in empty[0], "an empty address no longer opens the port to all"
PYTHON
"$work/venv/bin/python" ports.py
