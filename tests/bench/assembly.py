#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""How long it takes to find the contacts of n six-sided blocks, and n log n beside it.

    assembly.py [N]...

Not a test: nothing is judged. Without numbers: 25, 100, 200 and 400. The time is that of the
processor, and includes reading the files.
"""
import os
import re
import resource
import subprocess
import sys
import tempfile
from math import log

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

from assembly_cases import COMMAND, write_parts  # noqa: E402
from examples.assemblies import block  # noqa: E402


def pile(n):
    """n blocks, 5 x 5 in a layer, of one wavy map."""
    at = [(k % 5, k // 5 % 5, k // 25) for k in range(n)]
    return {"block%d" % k: block(low) for k, low in enumerate(at)}


def measure(n):
    with tempfile.TemporaryDirectory() as folder:
        paths = write_parts(pile(n), folder)
        start = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        run = subprocess.run([COMMAND, "assembly", "--check-only"] + paths, stdout=subprocess.PIPE,
                             universal_newlines=True, check=True)
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - start
        return seconds, int(re.search(r"Contacts +(\d+)", run.stdout).group(1))


def main():
    print("%6s %8s %9s %9s %14s" % ("parts", "faces", "contacts", "seconds", "us / (n log n)"))
    for n in [int(word) for word in sys.argv[1:]] or [25, 100, 200, 400]:
        seconds, contacts = measure(n)
        print("%6d %8d %9d %9.3f %14.1f" % (n, 6 * n, contacts, seconds,
                                            1e6 * seconds / (6 * n * log(6 * n))), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
