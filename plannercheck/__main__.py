"""`python -m plannercheck`: the command line."""

import sys

from plannercheck.cli.main import main

sys.exit(main())
