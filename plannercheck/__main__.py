"""`python -m plannercheck`: the command line."""

import sys

from plannercheck.cli import main

sys.exit(main())
