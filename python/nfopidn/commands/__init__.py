"""The command line: `nfopidn` and its commands."""

from nfopidn.commands.entry import main

__all__ = ["main"]
