"""What every wheel must do, wherever it was built: python tests/wheel.py, with the wheel installed.

It asks for nothing but what the wheel itself requires.
"""

import math
import tempfile
from pathlib import Path

import nfopidn
from nfopidn import commands

PUBLISHED_COST = 0.09205918448715  # tests/golden/costs.json


def main() -> None:
    """Simulate, tune, draw, write a file and C sources, run the executable's command."""
    result = nfopidn.simulate()
    assert math.isclose(result.cost, PUBLISHED_COST, rel_tol=1e-9), result.cost

    tuned = nfopidn.tune(structure="extended", robustness=None, rng=2)
    assert tuned.fun < 0.0165, tuned.fun
    robust = nfopidn.tune(rng=2, maxfev=2000)
    assert robust.verdict.colour != "red", robust.verdict.line
    assert nfopidn.tune(rng=2, maxfev=2000, workers=2).fun == robust.fun

    with tempfile.TemporaryDirectory() as folder:
        tuned.controller.save(Path(folder) / "controller.json")
        loaded = nfopidn.Controller.load(Path(folder) / "controller.json")
        assert loaded == tuned.controller
        nfopidn.plot.overview(result).savefig(Path(folder) / "overview.png")
        written = nfopidn.export_c(loaded, folder, scenario=tuned.scenario)
        assert all(path.stat().st_size > 0 for path in written)
        run = Path(folder) / "run.csv"
        assert commands.main(["simulate", "--quiet", "--out", str(run)]) == 0
        assert len(run.read_text().splitlines()) == 1 + len(result)
    print(f"nfopidn {nfopidn.__version__}: {nfopidn.__file__}")


if __name__ == "__main__":
    main()
