"""Time from the file of a robot to its response and its page, after imports: Talos on two feet, 38 coordinates, 12 rows of loops.

    python tests/benchmarks/robot_from_file.py [repetitions]

Prints the median and the best of each stage, and their share of the whole. Needs example-robot-data
(tests/models/robot/example_robot_data.py says where it is looked for); the goal is below 4 s for the whole, of which 1 s is for all but the page.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pinocchio  # noqa: F401  (imports are not timed)

import mbconstrained as mb
import mbconstrained.robot
from tests.robot import example_robot_data

STAGES = ("read", "equilibrium", "linearize", "solve", "evaluate", "page")
TIMES = np.linspace(0, 5, 500)


def once() -> list[float]:
    """Seconds of each stage."""
    clock = [time.perf_counter()]
    robot, guess = example_robot_data.talos()
    clock.append(time.perf_counter())
    posture = robot.equilibrium(guess, hold="all")
    clock.append(time.perf_counter())
    system = robot.linearize(posture, inputs={"push": mb.PointMotion("torso_2_link", along=(0, 1, 0))})
    clock.append(time.perf_counter())
    motion = system.solve(force=system.input_force({"push": mb.impulse([10.0])}))
    clock.append(time.perf_counter())
    motion(TIMES)
    clock.append(time.perf_counter())
    with tempfile.TemporaryDirectory() as folder:
        motion.write_page(Path(folder) / "page.html")
        clock.append(time.perf_counter())
    return np.diff(clock).tolist()


def main():
    if example_robot_data.folder() is None:
        sys.exit("example-robot-data is not installed; see tests/models/robot/example_robot_data.py")
    found = np.array([once() for _ in range(int(sys.argv[1]) if len(sys.argv) > 1 else 7)])
    whole = found.sum(axis=1)
    print(f"{'stage':<12} {'median ms':>10} {'best ms':>10} {'share':>7}")
    for name, column in zip(STAGES, found.T):
        print(f"{name:<12} {1e3 * np.median(column):10.1f} {1e3 * column.min():10.1f} {np.median(column / whole):7.0%}")
    print(
        f"{'all':<12} {1e3 * np.median(whole):10.1f} {1e3 * whole.min():10.1f} {1:7.0%}   goal 4000 ms; first run {1e3 * whole[0]:.1f} ms"
    )


if __name__ == "__main__":
    main()
