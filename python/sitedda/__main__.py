# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: python -m sitedda."""

import sys

from .program import main

if __name__ == "__main__":
    sys.exit(main())
