"""Whether a controller may be trusted with a robot: its verdict.

==================== ==========================================================
`verdict`            green, amber or red, with reasons and what is behind them
`Verdict`            the same as an object: prints as a table, has a JSON form
`digest`             by which a verdict says on which controller and scenario it is
==================== ==========================================================
"""

from nfopidn.robustness.files import read_verdict, save_with_verdict
from nfopidn.robustness.judgement import verdict
from nfopidn.robustness.verdict import Verdict, digest

__all__ = ["Verdict", "digest", "read_verdict", "save_with_verdict", "verdict"]
