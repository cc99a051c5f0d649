"""The answer: a function of time that you call, with its derivatives, jumps and Dirac impulses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..checks import counted, places_of, whole_number
from ..jordan.evidence import Evidence
from ..jordan.pairs import JordanPairs
from ..notices import Notice
from ..polynomial.matrix import PolynomialMatrix
from ..signals.bohl import BohlFunction
from ..signals.chunks import Piece
from ..signals.impulsive import ImpulsiveSmooth
from ..tolerances import noise_of
from .events import Event
from .solution import PairSolution

if TYPE_CHECKING:
    from ..exact.enclosure import Enclosure, ExactResponse
    from .reduced import ReducedSolution

#: So many coordinates are named where a response is shown in one line.
MOST_NAMES = 6


@dataclass(frozen=True, repr=False)
class Response:
    """x with A(d/dt) x = f from values at 0-.

    ``x(t)`` is the regular part at t > 0 (t = 0 means 0+): a number gives shape (r,), times of shape (T,) give
    (r, T), in any order and spacing, at the time of an event the right limit. Impulses are apart, never smeared.

    Attributes:
        polynomial_matrix: A(s).
        initial: x^(i)(0-) as row i, shape (q, r).
        force: f.
        solution: how x was found, from the Jordan pairs or, a large plain problem, from reduced equations.
        jump: x^(i)(0+) - x^(i)(0-), shape (q, r); exactly zero where the start is consistent.
        impulses: arrays (r,); the k-th multiplies the k-th derivative of Dirac's delta.
        events: jumps and impulses after t = 0, where the force starts, stops, changes or strikes, by ascending time.
    """

    polynomial_matrix: PolynomialMatrix
    initial: np.ndarray
    force: ImpulsiveSmooth
    solution: PairSolution | ReducedSolution
    jump: np.ndarray
    impulses: tuple[np.ndarray, ...]
    events: tuple[Event, ...] = field(default=(), kw_only=True)

    def __repr__(self) -> str:
        names, first = self.polynomial_matrix.coordinates, int(self.jump.any(axis=0).sum())
        shown = ", ".join(names[:MOST_NAMES]) + (", ..." if len(names) > MOST_NAMES else "")
        struck = int(np.any(self.impulses, axis=0).sum()) if self.impulses else 0
        return (
            f"{type(self).__name__}({counted(len(names), 'coordinate')}: {shown}; {counted(first, 'jump')} and "
            f"{counted(struck, 'impulse')} at t = 0; {counted(len(self.events), 'event')} later)"
        )

    def __call__(self, times) -> np.ndarray:
        """x at a time (-> (r,)) or at times (T,) (-> (r, T)).

        Raises:
            InputError: negative or not finite times.
            Overflow: the answer leaves the range of float64 within the times asked for.
        """
        return self.function(times)

    @property
    def pairs(self) -> JordanPairs:
        """The Jordan pairs of A(s)."""
        return self.solution.pairs

    @property
    def function(self) -> BohlFunction:
        """The regular part as a Bohl function C e^{J t} v."""
        return self.solution.function

    @property
    def coupling(self) -> float:
        """The largest entry of the transformation that separated the zeros."""
        return self.solution.coupling

    def derivative(self, order: int = 1) -> BohlFunction:
        """The classical derivative x^(order) for t > 0, a function of the same kind."""
        return self.function.derivative(order)

    def of(self, *coordinates: str | int) -> BohlFunction:
        """The function of some coordinates only, by name or number from 0, a row for each: no other is computed.

        Raises:
            InputError: no such coordinate.

        >>> from mbconstrained.response import solve
        >>> A = PolynomialMatrix([[[1.0, 0.0], [0.0, 2.0]], [[1.0, 0.0], [0.0, 1.0]]], coordinates=["slow", "fast"])
        >>> solve(A, initial=[[1.0, 3.0]]).of("fast")([0.0, 1.0]).round(3)
        array([[3.   , 0.406]])
        """
        return self.function.rows(places_of(coordinates, self.polynomial_matrix.coordinates, "coordinate"))

    def chunks(self, times, count: int | None = None) -> Iterator[Piece]:
        """x at many times as pairs (times, values), in order and of bounded size, for answers larger than memory.

        ``for part, values in x.chunks((0.0, 3600.0), count=10**8): ...`` makes even times piece by piece too.

        Args:
            times: shape (T,), in s; or the first and the last one, where a count is given.
            count: how many even times there are.

        Raises:
            InputError: times or a count that are not such.
        """
        return self.function.chunks(times, count)

    @property
    def start(self) -> np.ndarray:
        """x^(i)(0+) as row i, shape (q, r); what a jump leaves of a value below its rounding is zero."""
        start = self.initial + self.jump
        return np.where(np.abs(start) <= noise_of(np.abs(self.jump)), 0.0, start)

    def error_estimate(self, times, *, order: int = 0) -> float:
        """Estimate of max |error| / max |x^(order)| over the given times, of x itself or a derivative (``response.estimate``).

        Raises:
            InputError: times that are negative or not finite, an order that is no whole number of at least 0.
        """
        from .estimate import error_estimate

        order = whole_number(order, "order")
        return error_estimate(self, times, lambda x: x.derivative(order) if order else x.function)

    @cached_property
    def exact(self) -> ExactResponse:
        """The exact answer to the same data, floats taken as the exact numbers that they are: impulses, values at 0+, intervals."""
        from ..exact.enclosure import exact_response

        return exact_response(self.polynomial_matrix, self.initial, self.force)

    def enclose(self, times, digits: int = 15, *, order: int = 0) -> Enclosure:
        """Intervals that are sure to contain x(t), or a derivative of it, for the data taken exactly (``exact.enclosure``).

        X(s) is found over the rationals and summed over its certified poles in ball arithmetic, with more bits until each value
        has its digits; nothing of the numeric answer enters. The data are the entries of A(s), the values at 0- and the numbers
        that the force was made with; a phase that is a quarter turn to rounding is meant as one, as in the answer itself.

        Args:
            times: in s, a number or shape (T,).
            digits: of each value, relative to itself. A value that is zero, or cancels to thousands of bits, has a very narrow
                interval about zero instead.
            order: of the derivative.

        Returns:
            An ``Enclosure``: .lower, .upper (decimal strings, shape of x(t)), .contains(values), .error_bounds(values).

        Raises:
            InputError: times that are negative or not finite, digits or an order that are no whole numbers in range.
            SingularPolynomialMatrix: taken exactly, the data determine no motion.
            Overflow: values beyond 1e100000.

        >>> A = PolynomialMatrix([[[1.0]], [[1.0]]])  # x' = -x
        >>> from mbconstrained.response import solve
        >>> box = solve(A, initial=[[1.0]]).enclose(1.0, digits=20)
        >>> print(box.lower[0], box.upper[0])
        0.36787944117144232159552 0.36787944117144232159553
        """
        from ..exact.enclosure import structure_notices

        return self.exact.enclose(times, digits, order=order).with_notices(structure_notices(self, self.exact))

    def to_xarray(self, times):
        """x at times (T,) as an xarray ``DataArray`` with names, units, jumps and impulses (``response.frames``)."""
        from .frames import to_xarray

        return to_xarray(self, times)

    def to_pandas(self, times):
        """x at times (T,) as a pandas ``DataFrame`` with names, units, jumps and impulses (``response.frames``)."""
        from .frames import to_pandas

        return to_pandas(self, times)

    @cached_property
    def moved(self) -> tuple[Response, ...]:
        """Answers to the same problem with its data moved by about a rounding error (see ``response.estimate``)."""
        from .estimate import moved_responses

        return moved_responses(self)

    @cached_property
    def written(self) -> Response | None:
        """The answer to the data as they are written, where some counted as zero at s = 0 (see ``response.estimate``)."""
        from .estimate import written_response

        return written_response(self)

    @cached_property
    def evidence(self) -> tuple[Evidence, ...]:
        """Residuals, conditions and gaps that tell how far the answer can be trusted."""
        return self.solution.evidence

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """What the user should know: jumps, impulses, growth, doubtful decisions."""
        from .notices import response_notices

        return response_notices(self)
