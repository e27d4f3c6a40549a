"""From logs of commands and motion to a robot and its drive."""

from nfopidn.identification.identifier import identify
from nfopidn.identification.residuals import Whiteness
from nfopidn.identification.result import IdentificationResult

__all__ = ["IdentificationResult", "Whiteness", "identify"]
