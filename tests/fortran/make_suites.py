# SPDX-License-Identifier: GPL-3.0-or-later
"""The module that runs suites by name: python make_suites.py OUTPUT test_NAME.f90 …

The tests of a suite are the subroutines without arguments of its module, in the order of the
file; each is a case of its name, and begins with the same random numbers.
"""

import re
import sys
from pathlib import Path

HEAD = """!> The suites that meson.build lists, by name.
module suites
   implicit none
   private
   public :: run_suites

contains
"""
RUN = """
   !> Run the suite of that name, or all if it is blank; `found` says whether there is one.
   subroutine run_suites(name, found)
      character(len=*), intent(in) :: name
      logical, intent(out) :: found

      found = any(name == [character(len=64) :: '', {names}])
{runs}   end subroutine run_suites
"""


def tests_of(file: Path) -> list[str]:
    """Names of the tests of a suite."""
    return re.findall(r"^   subroutine (\w+)\(\)", file.read_text(), re.M)


def suite(name: str, tests: list[str]) -> str:
    """The subroutine that runs the tests of a suite."""
    uses = "".join(f"      use test_{name}, only: {test}\n" for test in tests)
    calls = "".join(
        f"      call sow(1)\n      call case('{test.replace('_', ' ')}')\n      call {test}()\n"
        for test in tests
    )
    return f"""
   subroutine run_{name}()
      use models, only: sow
      use testing, only: case
{uses}
{calls}   end subroutine run_{name}
"""


found = {Path(file).stem.removeprefix("test_"): tests_of(Path(file)) for file in sys.argv[2:]}
runs = "".join(f"      if (name == '' .or. name == '{n}') call run_{n}()\n" for n in found)
text = HEAD + RUN.format(names=", &\n         ".join(f"'{name}'" for name in found), runs=runs)
text += "".join(suite(name, tests) for name, tests in found.items())
Path(sys.argv[1]).write_text(text + "\nend module suites\n")
