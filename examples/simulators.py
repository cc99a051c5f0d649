"""How accurate are simulators, and what does it cost? The table of Hauksdottir and Sigurdsson, Eq. (47), beside the closed form.

Run it with ``python examples/simulators.py``; the smallest time step, 1e-4 s, takes about a minute.
"""

import sys

from mbconstrained.reports.simulators import simulator_report

if __name__ == "__main__":
    terminal = sys.stderr.isatty()
    report = simulator_report(progress=lambda text: print(f"\r{text:<60}", end="", file=sys.stderr) if terminal else None)
    if terminal:
        print("\r" + " " * 60 + "\r", end="", file=sys.stderr)
    print(report)
