"""Run the command line with `python -m nfopidn`."""

import sys

from nfopidn.commands import main

sys.exit(main())
