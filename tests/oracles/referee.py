"""Reads the cases and holds an answer against them.

Errors are relative to the largest value over all times and coordinates. An answer may lose what the condition
of the problem loses, times 1e4:
    fair    error <= max(1e-9, 1e4 kappa eps),  kappa: data and entries (or parameters) of A perturbed
    strict  error <= max(1e-9, 1e4 kappa eps),  kappa: data and parameters only
    void    the fair bar is above 0.1: the float64 entries do not determine the answer, so strict says little
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import mbconstrained as mb

EPS = np.finfo(float).eps
CASES = Path(__file__).with_name("cases")
NAMES = sorted(path.stem for path in CASES.glob("*.json"))


@dataclass(frozen=True)
class Case:
    """A problem and its answer; ``record`` is the case as read."""

    record: dict
    coefficients: np.ndarray
    initial: np.ndarray
    force: mb.ImpulsiveSmooth
    times: np.ndarray
    values: np.ndarray
    impulses: dict[int, np.ndarray]

    @property
    def scale(self) -> float:
        """The largest value of x; where x is zero, that of the data."""
        largest = np.abs(self.values).max(initial=0.0)
        return largest if largest > 0 else self.data_scale

    @property
    def data_scale(self) -> float:
        """The largest value at 0- or in the force."""
        vectors = [self.initial.ravel()] + [np.array(part["vec"], float) for part in self.record["forcing"]]
        return max(float(np.abs(np.concatenate(vectors)).max(initial=0.0)), 1e-300)

    @property
    def fair_bar(self) -> float:
        return max(1e-9, 1e4 * self.record["kappa"] * EPS)

    @property
    def strict_bar(self) -> float:
        parts = self.record["kappa_parts"]
        return max(1e-9, 1e4 * max(1.0, (parts["data"] or 0) + (parts["param"] or 0)) * EPS)

    @property
    def is_void(self) -> bool:
        return self.fair_bar >= 0.1

    def error(self, x: mb.Response) -> float:
        """Largest error over all times and coordinates, relative to the largest value."""
        found = x(self.times)
        assert found.shape == self.values.shape
        return float(np.abs(found - self.values).max(initial=0.0)) / self.scale

    def impulse_bar(self, order: int) -> float:
        """What an impulse of this order may be wrong by: its own size, its condition, and what it does to x at once."""
        sensitivity = self.record["impulse_abscond"]
        size = np.abs(self.impulses.get(order, np.zeros(1))).max()
        felt = max(np.abs(self.values).max(initial=0.0), self.data_scale) * self.times.min() ** (order + 1)
        return max(1e-9 * size, 1e4 * EPS * (sensitivity[order] if order < len(sensitivity) else 0.0), 1e-9 * felt)

    def impulse_error(self, x: mb.Response) -> float:
        """Largest error of an impulse, in units of its bar."""
        none = np.zeros(self.record["r"])
        worst = 0.0
        for order in {*range(len(x.impulses)), *self.impulses}:
            found = x.impulses[order] if order < len(x.impulses) else none
            error = np.abs(found - self.impulses.get(order, none)).max()
            worst = max(worst, float(error / self.impulse_bar(order)))
        return worst


@cache
def case(name: str) -> Case:
    """The case with this name."""
    record = json.loads((CASES / f"{name}.json").read_text())
    q, r = record["q"], record["r"]
    return Case(
        record=record,
        coefficients=np.array(record["A"], float).reshape(q + 1, r, r),
        initial=np.array(record["x0"], float).reshape(q, r),
        force=sum((_force(part) for part in record["forcing"]), mb.zero(r)),
        times=np.array(record["times"], float),
        values=np.array(record["x_reg"], float).reshape(-1, r).T,
        impulses={part["order"]: np.array(part["vec"], float) for part in record["impulses"]},
    )


@cache
def answer(name: str) -> mb.Response:
    """The package's answer to the case."""
    problem = case(name)
    return mb.solve(mb.PolynomialMatrix(problem.coefficients), problem.initial, problem.force)


def _force(part) -> mb.ImpulsiveSmooth:
    """vec t^k e^{at} cos|sin(wt), or vec delta^(k)."""
    if part["kind"] == "dirac":
        return mb.impulse(part["vec"], order=part["k"])
    phase = {"cos": 0.0, "sin": -np.pi / 2}[part["kind"]]
    return mb.term(part["vec"], power=part["k"], rate=part["a"], angular_frequency=part["w"], phase=phase)
