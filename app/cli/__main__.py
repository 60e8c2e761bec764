"""`python -m app.cli` is `observer-lab`."""

import sys

from .entry import main

sys.exit(main())
