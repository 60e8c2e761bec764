"""Run the command line: `python -m observer_lab` is `observer-lab`."""

import sys

from .cli import main

sys.exit(main())
