"""From logs of commands and motion to a robot and its drive: what nfopidn.identify() is made of."""

from nfopidn.identification.residuals import Whiteness
from nfopidn.identification.table import read_columns

__all__ = ["Whiteness", "read_columns"]
