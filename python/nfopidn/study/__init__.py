"""Studies: what could be reached at best, and the paper's tables and figures.

=================== =============================================================
`open_loop_optimum` the smallest cost over all torques, a bound for any controller
`OpenLoopOptimum`   what it returns
=================== =============================================================
"""

from nfopidn.study._optimum import GuessResult, OpenLoopOptimum, open_loop_optimum

__all__ = ["GuessResult", "OpenLoopOptimum", "open_loop_optimum"]
