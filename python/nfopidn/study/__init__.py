"""Studies: what could be reached at best, and the paper's tables and figures.

=================== =============================================================
`open_loop_optimum` the smallest cost over all torques, a bound for any controller
`OpenLoopOptimum`   what it returns
`reproduce`         the paper's tables and figures, and more, into a folder
=================== =============================================================
"""

from nfopidn.study.optimum import GuessResult, OpenLoopOptimum, open_loop_optimum
from nfopidn.study.reproduction import reproduce

__all__ = ["GuessResult", "OpenLoopOptimum", "open_loop_optimum", "reproduce"]
