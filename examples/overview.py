"""
The paper's scenario on one page
================================

One lap of the paper's path under the paper's gains.

``python examples/overview.py [overview.png]``
"""

import sys

import nfopidn

# %%
# Without arguments, `nfopidn.simulate` runs the published scenario. The result holds the cost E
# (eq. 41), further metrics and the run, sample by sample.
result = nfopidn.simulate()
print(result)
for name in ("position_rms", "heading_rms", "torque_peak"):
    print(name, result.metrics[name])

# %%
# All of it on one page.
figure = nfopidn.plot.overview(result)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "overview.png", dpi=120)
