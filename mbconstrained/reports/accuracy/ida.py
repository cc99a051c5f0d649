"""IDA of SUNDIALS, by scikit-sundae: variable-order BDF on the equations as they are, multipliers and singular masses included.

The unknowns are the coordinates, with rows of constraints their multipliers too, and of each as many derivatives as occur
in the equations, less one: nothing is reduced by hand. Rows of constraints stand in the equations twice differentiated
(index 1), once (index 2) or as they are (index 3). Without rows there is one form, E y' + F y = g, E possibly singular.

What the method is given: the Jacobian; values and derivatives at 0+ that fit, taken from the closed form, and by how much
they jump where the force starts, stops, changes or strikes, where it starts anew; absolute tolerances of rtol times the size
of each kind of unknown, as errors are measured. With index 2 multipliers and whatever else has no derivative in the equations
are kept out of the error test, with index 3 velocities too, as the manual of IDA advises for an index above 1 (scikit-sundae
does not offer IDASetSuppressAlg: their tolerance is made large instead; with the usual one the four-bar linkage, the delta
robot and the quadruped of the examples fail from rtol 1e-8 or 1e-10 on with index 2, and from 1e-6 on with index 3).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from ...mechanics.constraint import LEVELS
from ...signals import BohlFunction
from ..problem import Problem
from .descriptor import CONSTRAINED, Descriptor, plain
from .exosystem import Stretch, stretches
from .method import Evaluate, Failure, Method, Setting
from .reduced import BEGINNING, once_for_each

TOLERANCES = tuple(10.0**-digits for digits in range(4, 13, 2))

#: Steps from one time to the next: more than the time of any run allows.
MOST_STEPS = 10**7

#: The absolute tolerance of an unknown that is kept out of the error test, over its size.
UNTESTED = 1e10

#: Larger ones take SUNDIALS' own dense factorization longer than that of LAPACK.
MOST_PLAIN = 100


@dataclass(frozen=True)
class _Given:
    """What a problem hands over to the solver in one form of its equations.

    Attributes:
        form: the equations.
        stretches: of time, with the formulas of the force.
        start: y and y' at 0+.
        jumps: by how much y and y' jump at each knot.
        sizes: of y.
    """

    form: Descriptor
    stretches: tuple[Stretch, ...]
    start: tuple[np.ndarray, ...]
    jumps: tuple[dict[float, np.ndarray], ...]
    sizes: np.ndarray


def _given_in(form_of: Callable[[Problem], Descriptor]) -> Callable[[Problem], _Given]:
    """Found once for each problem, as the form itself."""

    @once_for_each
    def found(problem: Problem) -> _Given:
        form = form_of(problem)
        motion = [form.states(order) for order in (0, 1)]
        return _Given(
            form=form,
            stretches=tuple(stretches(form.force, problem.times, np.eye(len(form.places)))),
            start=tuple(function(0.0) for function in motion),
            jumps=tuple(_jumps(function) for function in motion),
            sizes=_sizes(motion[0], form.places, problem.times, form.count),
        )

    return found


def _prepare(given: _Given, rtol: float) -> Evaluate:
    """The solver with its options is the set-up."""
    form, nothing = given.form, np.zeros(len(given.form.places))
    solver = _Solver(form, rtol, rtol * given.sizes * np.where(form.tested, 1.0, UNTESTED))

    def evaluate() -> np.ndarray:
        values, found = given.start, []
        for stretch in given.stretches:
            if stretch.begin > 0:
                values = [value + jump.get(stretch.begin, nothing) for value, jump in zip(values, given.jumps)]
            states, values = solver.on(stretch, values)
            found.append(states[:, form.coordinates].T)
        return np.hstack(found)

    return evaluate


def _jumps(function: BohlFunction) -> dict[float, np.ndarray]:
    """By how much the values jump at each knot."""
    restarts = function.restarts
    return dict(zip(restarts.knots.tolist(), (function.coefficients @ restarts.jumps).T))


def _sizes(states: BohlFunction, places, times, count: int) -> np.ndarray:
    """As ``Reduced.sizes``: one of all coordinates, one of their derivatives, one of the multipliers."""
    values = np.abs(states(times))
    early = times <= BEGINNING * times[-1]
    kinds = [(unknown < count, order) for unknown, order in places]
    sizes = {}
    for kind in set(kinds):
        own = values[[kind == other for other in kinds]]
        sizes[kind] = own[:, early].max(initial=0.0) or own.max(initial=0.0) or 1.0
    return np.array([sizes[kind] for kind in kinds])


class _Solver:
    """IDA for one descriptor form, used again on every stretch."""

    def __init__(self, form: Descriptor, rtol: float, atol: np.ndarray):
        from sksundae.ida import IDA

        self.form, self.force = form, None
        both = np.hstack([form.F, form.E])

        def residual(t, y, yp, res):
            res[:] = both @ np.concatenate((y, yp)) - self.force(t)

        def jacobian(t, y, yp, res, cj, J):
            J[:] = form.F + cj * form.E

        algebraic = np.flatnonzero(form.algebraic).tolist()
        self.ida = IDA(
            residual,
            jacfn=jacobian,
            rtol=rtol,
            atol=atol,
            algebraic_idx=algebraic or None,
            max_num_steps=MOST_STEPS,
            linsolver="dense" if len(form.E) <= MOST_PLAIN else "lapackdense",
        )

    def on(self, stretch: Stretch, values: Sequence[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray]]:
        """y at the times of a stretch, shape (T, N), and y, y' at its end."""
        if stretch.end == stretch.begin:
            return np.repeat(values[0][None, :], len(stretch.times), axis=0), values
        self.force = stretch.force
        stops = np.union1d(stretch.begin, stretch.stops)
        # two stops alone are taken to ask for the solver's own steps: the middle makes three
        asked = stops if len(stops) > 2 else np.insert(stops, 1, stops.mean())
        answer = self.ida.solve(asked, *values)
        if not answer.success:
            raise Failure(answer.message)
        inside = np.searchsorted(asked, stretch.times)
        return answer.y[inside], [answer.y[-1], answer.yp[-1]]


def _installed() -> str:
    return "" if find_spec("sksundae") else "scikit-sundae is not installed"


def _has_rows(problem: Problem) -> bool:
    return problem.system is not None and bool(problem.system.rows)


def _refusal_of_index(problem: Problem, index: int) -> str:
    weaker = [row for row in problem.system.rows if row.order > 3 - index]
    if weaker:
        row, level = weaker[0], LEVELS[3 - index]
        return f"needs rows at {level} level; {row.name} is held at {row.level} level, which does not tell its {level}"
    return _installed()


def _with_rows(index: int) -> Method:
    given = _given_in(CONSTRAINED[index])
    return Method(
        f"IDA, index {index}",
        SETTINGS,
        lambda problem, rtol: _prepare(given(problem), rtol),
        lambda problem: _refusal_of_index(problem, index),
        concerns=_has_rows,
        library="sksundae.ida",
    )


SETTINGS = tuple(Setting(f"rtol {rtol:.0e}", rtol) for rtol in TOLERANCES)

_GIVEN = _given_in(plain)

METHODS = (
    *(_with_rows(index) for index in (1, 2, 3)),
    Method(
        "IDA",
        SETTINGS,
        lambda problem, rtol: _prepare(_GIVEN(problem), rtol),
        lambda problem: _installed(),
        concerns=lambda problem: not _has_rows(problem),
        library="sksundae.ida",
    ),
)
