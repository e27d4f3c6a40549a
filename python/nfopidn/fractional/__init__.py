"""Fractional operators s^order of sampled signals, with errors that can be read.

========================= ==========================================================
`discretise`              s^order as a filter, by one of six methods
`Discretisation`          its taps or zeros and poles, response, errors, conversions
`FractionalFilter`        s^order sample by sample, with memory up to infinity
`truncation_report`       how far a controller's operators are from s^alpha, s^-sigma
`to_discrete`             continuous gains to those of eq. 34 (eq. 25)
`to_continuous`           and back
`retune`                  a controller for another memory or sample time
========================= ==========================================================
"""

from nfopidn.fractional.conversion import RetuneReport, retune, to_continuous, to_discrete
from nfopidn.fractional.discretisation import METHODS, Discretisation, discretise
from nfopidn.fractional.filtering import FractionalFilter
from nfopidn.fractional.truncation import TruncationReport, truncation_report

__all__ = [
    "METHODS",
    "Discretisation",
    "FractionalFilter",
    "RetuneReport",
    "TruncationReport",
    "discretise",
    "retune",
    "to_continuous",
    "to_discrete",
    "truncation_report",
]
