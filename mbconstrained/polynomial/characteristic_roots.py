"""The rightmost roots of det(A(s) + sum of A_j(s) e^(-s delay_j)) = 0, which decide on stability.

There are infinitely many, but only finitely many to the right of each vertical line (retarded type). With the states w of the Jordan
pairs, w' = J w - sum of B C_j w(t - delay_j): the generator of this motion is discretized at Chebyshev points of the longest delay
(Breda, Maset and Vermiglio, SIAM J. Sci. Comput. 27, 2005), its eigenvalues are refined by Newton's method on the characteristic
equation itself, and the argument principle counts the roots to the right of the last one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil

import numpy as np

from ..ground.by_name import answering
from ..ground.checks import counted, whole_number
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import EPS
from ..linalg.scaling import balanced
from .delayed_terms import DelayedTerm, check_retarded, delayed_terms, measured_states
from .polynomial_matrix import PolynomialMatrix

#: Chebyshev points for each radian of a motion over the longest delay, the fewest, and the most states of a discretization.
EACH_RADIAN, FEWEST, MOST_STATES = 2.0, 12, 1600

#: So many times more eigenvalues than roots are refined.
MORE = 2

#: Steps of Newton's method, and how far they may lead from an eigenvalue of the discretization, relative to its modulus.
NEWTON, NEAR = 30, 0.1

#: Roots are one where they differ by so much less than their size and 1 / delay; computed ones are accurate to this residual.
SAME, ACCURATE = EPS**0.5, 1e4 * EPS

#: The largest turn of a determinant between two points of a line, in rad, and the most halvings of an interval.
TURN, HALVINGS = 0.7, 40


@dataclass(frozen=True, repr=False, eq=False)
class CharacteristicRoots(Displayed):
    """The rightmost roots of equations with delays, descending by real part; of each pair the one above the real axis.

    Attributes:
        eigenvalues: s, complex, in 1/s, shape (m,).
        shapes: x of x e^(s t), largest entry 1, shape (r, m).
        residuals: the smallest singular value of the characteristic matrix relative to its largest, shape (m,).
        is_complete: whether the argument principle finds no other root to the right of the last one.
        coordinates: names of the rows of the shapes.
    """

    eigenvalues: np.ndarray
    shapes: np.ndarray
    residuals: np.ndarray
    is_complete: bool
    coordinates: tuple[str, ...] = field(default=())

    def _summary(self) -> str:
        return (
            f"{counted(len(self.eigenvalues), 'root')}, rightmost {self.eigenvalues[0]:.6g} 1/s"
            if len(self.eigenvalues)
            else "no roots"
        )

    def _tables(self) -> tuple[TextTable, ...]:
        cells = (
            (f"{s.real:.6g}", f"{s.imag:.6g}", f"{abs(s.imag) / (2 * np.pi):.6g}", f"{zeta:.4g}")
            for s, zeta in zip(self.eigenvalues, self.damping_ratios)
        )
        heads = ("real part (1/s)", "imaginary part (rad/s)", "frequency (Hz)", "damping ratio")
        return TextTable("Characteristic roots", heads, tuple(cells)), notice_table(self.notices)

    @property
    def damping_ratios(self) -> np.ndarray:
        """-Re s / |s|; 1 of s = 0."""
        size = np.abs(self.eigenvalues)
        return np.divide(-self.eigenvalues.real, size, out=np.ones(len(size)), where=size > 0)

    @property
    def stability_margin(self) -> float:
        """Minus the largest real part, in 1/s: negative where motions grow."""
        return -float(self.eigenvalues.real.max(initial=-np.inf))

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Roots in the right half plane, and a list that may not be complete."""
        growing = self.eigenvalues[self.eigenvalues.real > 0]
        result = []
        if len(growing):
            text = f"{counted(len(growing), 'root')} of the equations with delays in the right half plane, the rightmost {growing[0]:.6g} 1/s"
            result.append(Notice(NoticeKind.UNSTABLE, text))
        if not self.is_complete:
            text = "the argument principle counts other roots to the right of the last one; the list may not be complete"
            result.append(Notice(NoticeKind.ACCURACY, text, doubtful=True))
        return tuple(result)


@answering
def characteristic_roots(A: PolynomialMatrix, delayed, count: int = 10) -> CharacteristicRoots:
    """Return the rightmost roots s of det(A(s) + sum of A_j(s) e^(-s delay_j)) = 0.

    Args:
        A: A(s), degree q, size r.
        delayed: A_j(s) by their delays in s, as of ``mbconstrained.solve``.
        count: how many, a complex pair counts once.

    Returns:
        ``CharacteristicRoots``: ``eigenvalues``, ``shapes``, ``stability_margin``, ``damping_ratios``.

    Raises:
        InputError: terms of neutral or advanced type; more roots than can be computed.

    >>> A = PolynomialMatrix([[[0.0]], [[1.0]]])
    >>> roots = characteristic_roots(A, {1.0: [[np.pi / 2]]}, 1)  # s + (pi / 2) e^-s = 0: s = i pi / 2
    >>> roots.eigenvalues.imag.round(12).tolist(), roots.is_complete
    ([1.570796326795], True)
    """
    return rightmost_roots(A, delayed_terms(delayed, A.size), count)


def rightmost_roots(A: PolynomialMatrix, terms: Sequence[DelayedTerm], count: int = 10) -> CharacteristicRoots:
    """The rightmost roots with checked terms."""
    count = whole_number(count, "count", minimum=1)
    if not terms:
        raise InputError(
            "characteristic_roots: these equations have no delays; their eigenvalues are A.eigenvalues, or modes of a system"
        )
    equation = _Equation.of(A, terms)
    roots, vectors = equation.roots(count)
    kept = np.argsort(-roots.real, kind="stable")[: count + 1]
    complete = False
    if len(kept):
        next_real = roots[kept[count]].real if len(kept) > count else -np.inf
        last = roots[kept[:count][-1]].real
        line = (last + next_real) / 2 if np.isfinite(next_real) else last - max(abs(last), 1 / equation.delays[-1])
        right = sum(2 if root.imag else 1 for root in roots if root.real > line)
        complete = equation.count_right_of(line, roots) == right
    kept = kept[:count]
    shapes = np.array([equation.output @ vectors[k] for k in kept]).reshape(len(kept), A.size).T
    largest = shapes[np.abs(shapes).argmax(axis=0), np.arange(len(kept))] if len(kept) else np.ones(0)
    shapes = shapes / np.where(largest == 0, 1.0, largest)
    residuals = np.array([equation.singular(roots[k])[2] for k in kept])
    return CharacteristicRoots(roots[kept], shapes, residuals, bool(complete), A.coordinates)


@dataclass(frozen=True, eq=False)
class _Equation:
    """T(s) = s I - J - sum of E_j e^(-s delay_j).

    Attributes:
        own: J, shape (n, n).
        delayed: E_j = -B C_j.
        delays: ascending.
        output: x by the states, shape (r, n).
    """

    own: np.ndarray
    delayed: tuple[np.ndarray, ...]
    delays: np.ndarray
    output: np.ndarray

    @classmethod
    def of(cls, A: PolynomialMatrix, terms: Sequence[DelayedTerm]) -> _Equation:
        pairs = A.jordan_pairs()
        check_retarded(pairs, terms)
        J, B, C = (np.asarray(matrix, dtype=float) for matrix in (pairs.finite.J, pairs.finite.B, pairs.finite.C))
        E = [-B @ measured for measured in measured_states(pairs, terms)]
        pattern = np.abs(J) + sum(np.abs(one) for one in E)
        units = balanced(pattern)[1]
        scaled = [one * units / units[:, None] for one in (J, *E)]
        return cls(scaled[0], tuple(scaled[1:]), np.array([term.delay for term in terms]), C * units)

    def __call__(self, s: complex) -> tuple[np.ndarray, np.ndarray]:
        """T(s) and T'(s)."""
        T, slope = s * np.eye(len(self.own)) - self.own, np.eye(len(self.own), dtype=complex)
        for E, delay in zip(self.delayed, self.delays):
            turned = E * np.exp(-s * delay)
            T, slope = T - turned, slope + delay * turned
        return T, slope

    def singular(self, s: complex) -> tuple[np.ndarray, np.ndarray, float]:
        """The singular vectors of the smallest singular value of T(s), and that relative to the size of the terms."""
        T, _ = self(s)
        size = abs(s) + np.linalg.norm(self.own, 2)
        size += sum(np.linalg.norm(E, 2) * np.exp(-s.real * delay) for E, delay in zip(self.delayed, self.delays))
        left, values, right = np.linalg.svd(T)
        return left[:, -1], right[-1].conj(), float(values[-1] / size)

    def roots(self, count: int) -> tuple[np.ndarray, list[np.ndarray]]:
        """At least so many rightmost roots, where there are as many, with the null vectors."""
        n, longest = len(self.own), float(self.delays[-1])
        if not n:
            return np.zeros(0, dtype=complex), []
        rate = max(np.abs(np.linalg.eigvals(self.own)).max(), sum(np.linalg.norm(E, 2) for E in self.delayed))
        points = FEWEST + 2 * count + ceil(EACH_RADIAN * min(rate * longest, MOST_STATES))
        before = None
        while True:
            if n * (points + 1) > MOST_STATES:
                raise InputError(
                    f"characteristic_roots: {n} states that turn by {rate * longest:.3g} rad in the longest delay need a matrix of more "
                    f"than {MOST_STATES} rows; ask for fewer roots, or use frequency responses"
                )
            starts = np.linalg.eigvals(self._discretized(points))
            starts = starts[(starts.imag >= 0) & np.isfinite(starts)]
            roots, vectors = self._refined(starts[np.argsort(-starts.real, kind="stable")][: MORE * (count + FEWEST)])
            chosen = np.argsort(-roots.real, kind="stable")[: count + 1]
            own = roots[chosen]
            if (
                before is not None
                and len(own) > count
                and len(before) == len(own)
                and (np.abs(own - before) <= self._same(own)).all()
            ):
                return roots, vectors
            before, points = own, ceil(1.5 * points)

    def _same(self, roots: np.ndarray) -> np.ndarray:
        return SAME * (np.abs(roots) + 1 / self.delays[-1])

    def _discretized(self, points: int) -> np.ndarray:
        """The generator at Chebyshev points of [-longest delay, 0], the first at 0, shape (n (N + 1), n (N + 1))."""
        n, longest = len(self.own), self.delays[-1]
        k = np.arange(points + 1)
        x = np.cos(np.pi * k / points)
        weights = np.where((k == 0) | (k == points), 2.0, 1.0) * (-1.0) ** k
        difference = x[:, None] - x + np.eye(points + 1)
        D = np.outer(weights, 1 / weights) / difference
        D -= np.diag(D.sum(axis=1))
        total = np.kron(D * (2 / longest), np.eye(n))
        total[:n] = 0.0
        total[:n, :n] = self.own
        for E, delay in zip(self.delayed, self.delays):
            total[:n] += np.kron(_interpolation(x, 1 / weights, 1 - 2 * delay / longest), E)
        return total

    def _refined(self, starts: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
        """Distinct roots near the starts by Newton's method, and their null vectors."""
        roots: list[complex] = []
        vectors: list[np.ndarray] = []
        for start in starts:
            s = self._root(complex(start))
            if s is None or s.imag < 0 or any(abs(s - one) <= self._same(np.array([s]))[0] for one in roots):
                continue
            _, right, residual = self.singular(s)
            if residual <= ACCURATE:
                roots.append(s)
                vectors.append(right)
        return np.array(roots, dtype=complex), vectors

    def _root(self, start: complex) -> complex | None:
        """The root near a start by Newton's method on the smallest singular value; None where it leads away."""
        s = start
        for _ in range(NEWTON):
            with np.errstate(all="ignore"):  # far to the left e^(-s delay) leaves the range of float64
                T, slope = self(s)
                if not np.isfinite(T).all():
                    return None
                left, right, _ = self.singular(s)
                step = (left.conj() @ T @ right) / (left.conj() @ slope @ right)
            if not np.isfinite(step) or abs(s - step - start) > NEAR * (abs(start) + 1 / self.delays[-1]):
                return None
            s = s - step
            if abs(step) <= 4 * EPS * (abs(s) + EPS / self.delays[-1]):
                break
        return complex(s.real) if not start.imag and abs(s.imag) <= SAME * (abs(s) + 1 / self.delays[-1]) else s

    def count_right_of(self, line: float, near: np.ndarray) -> int:
        """The number of roots with a real part above a line, by the turns of det T along it (argument principle).

        Of g(w) = det T(line + i w) / (i w + a)^n with a > 0, which tends to 1.
        """
        n = len(self.own)
        bound = abs(line) + np.linalg.norm(self.own, 2)
        bound += sum(np.linalg.norm(E, 2) * np.exp(-line * delay) for E, delay in zip(self.delayed, self.delays))
        end = 20 * n * bound
        close = [s.imag + abs(s.real - line) * f for s in near for f in (-3, -1, -0.3, 0, 0.3, 1, 3)]
        omega = np.unique(np.clip([0.0, *np.geomspace(bound / 1e3, end, 60), *close], 0.0, end))

        def phase(w: float) -> complex:
            sign, _ = np.linalg.slogdet(self(complex(line, w))[0])
            return complex(sign * np.exp(-1j * n * np.angle(1j * w + bound)))

        values = {w: phase(w) for w in omega.tolist()}
        pending, total = list(zip(omega.tolist(), omega[1:].tolist())), 0.0
        while pending:
            a, b = pending.pop()
            middle = (a + b) / 2
            values[middle] = phase(middle)
            halves = [float(np.angle(values[middle] / values[a])), float(np.angle(values[b] / values[middle]))]
            if max(map(abs, halves)) <= TURN or b - a <= 2.0**-HALVINGS * end:
                total += sum(halves)
            else:
                pending += [(a, middle), (middle, b)]
        return round(-(total + float(np.angle(1 / values[omega[-1]]))) / np.pi)


def _interpolation(x: np.ndarray, weights: np.ndarray, at: float) -> np.ndarray:
    """The row that interpolates values at Chebyshev points at another point (barycentric formula), shape (1, N + 1)."""
    distance = at - x
    if (distance == 0).any():
        return (distance == 0).astype(float)[None]
    own = weights / distance
    return (own / own.sum())[None]
