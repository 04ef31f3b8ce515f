#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Table 1 of Zhang, Wang, Hughes (2012), our models beside the paper's.

    table1.py [--model NAME]... [--effort E] [--threads N] [--check] [--keep DIR]

Builds every model with the command that TSOLID_COMMAND names, or that of the newest build tree;
--check also compares the solids with the surfaces and lists all that is not as it must be.
"""
import argparse
import os
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

from model_chain import HEADING, PAPER, build, row  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description="Our table 1; see the top of the file.")
    parser.add_argument("--model", action="append", choices=sorted(PAPER), default=[])
    parser.add_argument("--effort", default="default")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--keep", metavar="DIR", help="where the files are to stay")
    options = parser.parse_args()
    words = ("--effort", options.effort, "--threads", str(options.threads))
    bad = 0
    print("ours (the paper's)\n" + HEADING)
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or temporary
        os.makedirs(folder, exist_ok=True)
        for name in options.model or PAPER:
            chain = build(name, folder, *words)
            if chain.report is None:
                print("%-14s %s" % (name, chain.text.strip()))
                bad += 1
                continue
            print(row(name, chain.report, chain.seconds), flush=True)
            for text in chain.failures(0.0) if options.check else ():
                print("%-14s %s" % ("", text))
                bad += 1
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
