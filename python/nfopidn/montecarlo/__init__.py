"""Many runs with drawn parameters: how a controller does where the plant is not known exactly.

nfopidn.monte_carlo() makes them; here are the distributions and what the result is made of.
"""

from nfopidn.montecarlo.distributions import Choice, LogNormal, Normal, Uniform
from nfopidn.montecarlo.indices import SobolIndices, sobol_indices
from nfopidn.montecarlo.result import Sensitivity, Yield

__all__ = [
    "Choice",
    "LogNormal",
    "Normal",
    "Sensitivity",
    "SobolIndices",
    "Uniform",
    "Yield",
    "sobol_indices",
]
