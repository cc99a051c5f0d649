"""How accurate are simulators, and what does it cost? The closed form, scipy.signal.lsim and control.forced_response.

The transfer function and the table are those of Hauksdottir and Sigurdsson, Eq. (47): relative errors at t = 10 s and t = 100 s
of the ramp and the parabola responses. The simulators have a time step: an input that is linear between two times is
followed exactly, the error for the parabola is dt^2/12 y_1/y_3.

Run it with ``python examples/simulators.py``; the smallest time step, 1e-4 s, takes about a minute.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from statistics import median
from time import perf_counter

import numpy as np

from mbconstrained.control.rational import scalar_matrix
from mbconstrained.control.transfer_function import transfer_function_response
from mbconstrained.ground.errors import InputError

#: The zeros of (47), and the factors of its denominator in ascending powers.
ZEROS = ("0.69", "0.51", "0.36", "0.22")
PAIRS, DOUBLE = (("0.67", "0.20"), ("0.46", "0.32"), ("0.16", "0.36")), "0.11"

TIMES, STEPS, GAMMAS = (10.0, 100.0), (1.0, 1e-2, 1e-4), (2, 3)

#: y_gamma at 10 and 100, to 32 digits, from ball arithmetic (Arb), confirmed by residues with 60 digits.
REFERENCE = {
    0: ("6.2842390938231284146571470226272", "0.0011192169348073601338595695755866"),
    1: ("40.795547852808303057519299818904", "96.664772697369375799832049162454"),
    2: ("131.18767570451995806147247349107", "8200.0345467066184141515490506938"),
    3: ("295.56699326741597332670554532835", "353938.78428300740487440407983976"),
}

#: The figures that the paper prints for MATLAB's lsim.
PRINTED = {
    2: ((8.0e-15, 6.7e-16), (5.0e-14, 4.4e-15), (-7.7e-14, 1.3e-14)),
    3: ((1.2e-02, 2.3e-05), (1.2e-06, 2.3e-09), (1.2e-10, 1.4e-13)),
}

#: Repeats of each run, of which the median run time is reported. Runs with the smallest step take seconds.
REPEATS, REPEATS_OF_SMALLEST_STEP = 5, 1


@dataclass(frozen=True)
class Run:
    """One simulator on one input.

    Attributes:
        simulator: its name.
        gamma: of the input I_gamma.
        step: its time step in s; None where it has none.
        errors: relative errors at t = 10 and t = 100.
        seconds: median of the run times; of the closed form including its poles. None where it is not known.
    """

    simulator: str
    gamma: int
    step: float | None
    errors: tuple[float, float]
    seconds: float | None


@dataclass(frozen=True)
class SimulatorReport:
    """The runs, and the simulators that are not installed."""

    runs: tuple[Run, ...]
    missing: tuple[str, ...] = ()

    def __str__(self) -> str:
        lines = ["Relative errors at t = 10 s and t = 100 s, transfer function (47) of Hauksdottir and Sigurdsson", ""]
        lines += [f"{'input':<6} {'simulator':<24} {'step in s':>9}  {'at t = 10':>10} {'at t = 100':>10}  {'run time':>10}"]
        lines += [_line(run) for run in self.runs]
        printed = {run.gamma for run in self.runs} & set(PRINTED)
        lines += [
            _line(Run("MATLAB lsim, printed", gamma, *row, None)) for gamma in sorted(printed) for row in zip(STEPS, PRINTED[gamma])
        ]
        lines += [""] * bool(self.missing) + [f"{name} is not installed: it is left out" for name in self.missing]
        return "\n".join(lines)


def example_47() -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
    """Numerator and denominator of Eq. (47), exactly, the highest power first.

    >>> numerator, denominator = example_47()
    >>> numerator[1], denominator[1]
    (Fraction(89, 50), Fraction(14, 5))
    """
    one = Fraction(1)
    above = [(Fraction(zero), one) for zero in ZEROS]
    below = [(Fraction(a) ** 2 + Fraction(w) ** 2, 2 * Fraction(a), one) for a, w in PAIRS] + [(Fraction(DOUBLE), one)] * 2
    return tuple(reduce(np.convolve, above)[::-1]), tuple(reduce(np.convolve, below)[::-1])


def simulator_report(
    gammas: Sequence[int] = GAMMAS, steps: Sequence[float] = STEPS, progress: Callable[[str], None] = lambda text: None
) -> SimulatorReport:
    """Run all simulators on the inputs I_gamma with all steps.

    Args:
        gammas: of 1, 2, 3: inputs that are functions.
        steps: in s; they must divide 10.
        progress: called with the name of each run.

    Raises:
        InputError: another gamma.
    """
    if unknown := sorted(set(gammas) - {1, 2, 3}):
        raise InputError(f"gammas: found {unknown[0]}; expected some of 1, 2 and 3, inputs that simulators with a step can take")
    stepping, missing = {"scipy.signal.lsim": _lsim, "control.forced_response": _forced_response}, []
    if not _has_control():
        missing.append("control")
        del stepping["control.forced_response"]
    runs = []
    for gamma in gammas:
        progress(f"I_{gamma}: mbconstrained")
        runs.append(_run("mbconstrained", gamma, None, _engine))
        for name, simulate in stepping.items():
            for step in steps:
                progress(f"I_{gamma}: {name}, step {step:g} s")
                runs.append(_run(name, gamma, step, simulate))
    return SimulatorReport(tuple(runs), tuple(missing))


def relative_errors(values: Sequence[float], gamma: int) -> tuple[float, float]:
    """(y - reference) / reference at t = 10 and t = 100, the reference with all of its digits."""
    first, second = (float(Fraction(float(y)) / Fraction(text) - 1) for y, text in zip(values, REFERENCE[gamma]))
    return first, second


def _run(name: str, gamma: int, step: float | None, simulate: Callable) -> Run:
    repeats = REPEATS if step is None or step >= 1e-3 else REPEATS_OF_SMALLEST_STEP
    seconds = []
    for _ in range(repeats):
        begin = perf_counter()
        values = simulate(gamma, step)
        seconds.append(perf_counter() - begin)
    return Run(name, gamma, step, relative_errors(values, gamma), median(seconds))


def _engine(gamma, _) -> np.ndarray:
    numerator, denominator = example_47()
    scalar_matrix.cache_clear()  # the time to find the poles is part of the run time
    return transfer_function_response(numerator, denominator, gamma)(np.array(TIMES))[0]


def _lsim(gamma, step) -> np.ndarray:
    from scipy import signal

    t, u = _sampled(gamma, step)
    return _at_times(signal.lsim(signal.TransferFunction(*_floats()), u, t)[1], step)


def _forced_response(gamma, step) -> np.ndarray:
    import control

    t, u = _sampled(gamma, step)
    return _at_times(control.forced_response(control.tf(*_floats()), t, u).outputs, step)


def _sampled(gamma, step) -> tuple[np.ndarray, np.ndarray]:
    t = np.arange(round(TIMES[-1] / step) + 1) * step
    return t, {1: np.ones_like(t), 2: t, 3: t**2 / 2}[gamma]


def _floats() -> list[list[float]]:
    return [[float(c) for c in polynomial] for polynomial in example_47()]


def _at_times(values, step) -> np.ndarray:
    return values[[round(time / step) for time in TIMES]]


def _has_control() -> bool:
    from importlib.util import find_spec

    return find_spec("control") is not None


def _line(run: Run) -> str:
    step = "none" if run.step is None else f"{run.step:g}"
    errors = " ".join(f"{error:>10.1e}" for error in run.errors)
    return f"{f'I_{run.gamma}':<6} {run.simulator:<24} {step:>9}  {errors}  {_duration(run.seconds):>10}".rstrip()


def _duration(seconds: float | None) -> str:
    if seconds is None:
        return ""
    return f"{seconds * 1e3:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


if __name__ == "__main__":
    terminal = sys.stderr.isatty()
    report = simulator_report(progress=lambda text: print(f"\r{text:<60}", end="", file=sys.stderr) if terminal else None)
    if terminal:
        print("\r" + " " * 60 + "\r", end="", file=sys.stderr)
    print(report)
