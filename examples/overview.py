"""Simulate the paper's scenario and draw it on one page."""

import sys

import nfopidn

result = nfopidn.simulate()
figure = nfopidn.plot.overview(result)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "overview.png", dpi=120)
print(result)
