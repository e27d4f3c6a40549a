"""Whether a controller may be trusted with a robot: its verdict.

==================== ==========================================================
`verdict`            green, amber or red, with reasons and what is behind them
`Verdict`            the same as an object: prints as a table, has a JSON form
`scenario_digest`    by which a file says for which scenario a verdict is
==================== ==========================================================
"""

from nfopidn.robustness.files import read_verdict, save_with_verdict
from nfopidn.robustness.judgement import verdict
from nfopidn.robustness.verdict import Verdict, scenario_digest

__all__ = ["Verdict", "read_verdict", "save_with_verdict", "scenario_digest", "verdict"]
