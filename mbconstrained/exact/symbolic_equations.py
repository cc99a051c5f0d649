"""The constrained form [V^T (M s^2 + C s + K); A s^level] x = [V^T f; b] with symbols, as ``mechanics`` has it in numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy
from sympy.polys.matrices import DomainMatrix

from ..ground.errors import ContradictoryConstraints, InputError
from .closed_form import ClosedForm, FormulaParameter
from .formula_printers import TextPrinter
from .symbolic.fields import exact_expression
from .symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from .symbolic.symbolic_response import SymbolicResponse, delta, initial_symbols


@dataclass(frozen=True, eq=False)
class Row:
    """A constraint row: the sum of coefficient times coordinate, in the derivative of this order, equals the value."""

    name: str
    coefficients: np.ndarray
    order: int
    value: sympy.Expr


@dataclass(frozen=True, eq=False)
class ExactForm:
    """[V^T (M s^2 + C s + K); A s^level], V, an array (n, n - k) of expressions, and the independent rows, those of position level first."""

    polynomial_matrix: SymbolicPolynomialMatrix
    null_space: np.ndarray
    rows: tuple[Row, ...]

    def force(self, applied: Sequence[sympy.Expr]) -> list[sympy.Expr]:
        return [*(self.null_space.T @ np.array(applied, dtype=object)), *(row.value for row in self.rows)]


def exact_form(matrices: Sequence[np.ndarray], rows: Sequence[Row], names: Sequence[str]) -> ExactForm:
    """The constrained form of M x'' + C x' + K x = f."""
    kept = _independent(sorted(rows, key=lambda row: row.order))
    size, V = len(names), np.array(sympy.eye(len(names)).tolist(), dtype=object)
    if kept:  # V as columns
        matrix = DomainMatrix.from_Matrix(sympy.Matrix([list(row.coefficients) for row in kept])).to_field()
        basis = matrix.nullspace(divide_last=True).to_Matrix().tolist()
        V = np.array(basis, dtype=object).reshape(len(basis), size).T
    coefficients = []
    for order, matrix in enumerate(matrices):
        constrained = [row.coefficients if row.order == order else np.zeros(size, dtype=int) for row in kept]
        coefficients.append([*(V.T @ matrix).tolist(), *(list(row) for row in constrained)])
    return ExactForm(SymbolicPolynomialMatrix(coefficients, names), V, tuple(kept))


def _independent(rows: Sequence[Row]) -> list[Row]:
    """The rows that are no combination of those before them: each column without a pivot has the factors of its combination."""
    if not rows:
        return []
    columns = sympy.Matrix([list(row.coefficients) for row in rows]).T
    reduced, pivots = DomainMatrix.from_Matrix(columns).to_field().rref()
    kept, factors = [rows[pivot] for pivot in pivots], reduced.to_Matrix()
    for place, row in enumerate(rows):
        combination = sum((c * each.value for c, each in zip(factors[:, place], kept) if each.order == row.order), sympy.S.Zero)
        if place not in pivots and sympy.simplify(row.value - combination) != 0:
            text_of = TextPrinter().doprint
            raise ContradictoryConstraints(
                f'constraint "{row.name}" has the value {text_of(row.value)}, but it follows from the rows before it with the value '
                f"{text_of(sympy.simplify(combination))}; make the values agree or take one of the rows out"
            )
    return kept


def followed(given: np.ndarray, known: np.ndarray, rows: Sequence[Row], order: int) -> np.ndarray:
    """Values of one order at 0-, those that are not known chosen so that the rows hold."""
    chosen = [row for row in rows if row.order <= order]
    rest = [sympy.expand((row.value if row.order == order else 0) - row.coefficients @ given) for row in chosen]
    if not any(rest):
        return given
    free = [i for i in range(len(given)) if not known[i] and any(row.coefficients[i] != 0 for row in chosen)]
    A = sympy.Matrix([[row.coefficients[i] for i in free] for row in chosen])
    solution, _ = A.gauss_jordan_solve(sympy.Matrix(rest))
    factored = given.copy()
    for i, value in zip(free, solution):
        factored[i] = sympy.factor(value)
    return factored


# Parameters as symbols: numbers and expressions of parameters as exact expressions of sympy.

#: Digits of pi among rational numbers.
PI_DIGITS = 45

#: Ends the names that parameters have in the engine: no name of a user, nor s, t or a value at 0- (x1_0), ends with it.
MARK = "·"


class Symbols:
    """The symbols of named parameters, or their default values, and the conversion of entries to expressions.

    To the engine all symbols are positive, with names of their own, so that a parameter may be called s or x1_0. A parameter
    whose default value is negative is minus one there, and pi, which is no rational number, is a symbol; ``finished`` puts
    back what they stand for. With ``numbers`` the parameters are their default values from the start.
    """

    def __init__(self, values: Mapping[str, float], units: Mapping[str, str] | None = None, numbers: bool = False):
        self.time = sympy.Symbol("t", real=True)
        self.numbers = numbers
        self.pi = sympy.Symbol("π", positive=True)
        self._engine: dict[str, sympy.Expr] = {}
        self._back: dict[sympy.Symbol, sympy.Expr] = {self.pi: sympy.pi}
        self.parameters: list[FormulaParameter] = []
        if numbers:
            self._engine = {name: exact_expression(value, name) for name, value in values.items()}
            self.pi = sympy.Rational(str(sympy.pi.evalf(PI_DIGITS)))
            return
        for name, value in values.items():
            inner = sympy.Symbol(f"{name}{MARK}", positive=True)
            shown = sympy.Symbol(name, negative=True) if value < 0 else sympy.Symbol(name, positive=True)
            self._engine[name], self._back[inner] = (-inner, -shown) if value < 0 else (inner, shown)
            self.parameters.append(FormulaParameter(shown, name, exact_expression(value, name), (units or {}).get(name, "")))

    def of(self, entry) -> sympy.Expr:
        """A number as the decimal that it is written as, an expression of parameters as such."""
        tree = getattr(entry, "tree", None)
        return exact_expression(entry, "number") if tree is None else self.expression(tree)

    def expression(self, tree) -> sympy.Expr:
        """A tree of operations, numbers and names."""
        return tree.value(sympy.Rational, {**self._engine, "pi": self.pi})

    def all_of(self, entries) -> np.ndarray:
        """An array of entries as an array of expressions."""
        entries = np.asarray(entries, dtype=object)
        expressions = np.empty(entries.shape, dtype=object)
        for place in np.ndindex(expressions.shape):
            expressions[place] = self.of(entries[place])
        return expressions

    @staticmethod
    def readable(text: str) -> str:
        """A message of the engine with the names that the user gave."""
        return text.replace(MARK, "")

    def finished(self, form: ClosedForm) -> ClosedForm:
        """The formula with what the symbols of the engine stand for, and the parameters that are left in it."""

        def back(expression):
            return expression.xreplace(self._back) if isinstance(expression, sympy.Basic) else expression

        conditions = {kind: tuple(map(back, getattr(form, kind))) for kind in ("admissible", "continuous", "assumptions")}
        conditions["assumptions"] = tuple(each for each in conditions["assumptions"] if not each.is_number)
        form = replace(form.mapped(back), **conditions)
        form = replace(form, impulses=tuple(replace(each, time=back(each.time)) for each in form.impulses))
        parts = (*form.quantities, *map(sympy.sympify, (each for kind in conditions.values() for each in kind)))
        used = set().union(*(each.free_symbols for each in parts))
        return replace(form, parameters=tuple(p for p in self.parameters if p.symbol in used))


# Forces as expressions in t, zero before they begin.

#: A record of more samples gives a formula that nobody reads.
MOST_SAMPLES = 30


def begun(expression: sympy.Expr, t: sympy.Symbol, delay: sympy.Expr) -> sympy.Expr:
    """f(t - delay), zero before."""
    if delay == 0:
        return expression
    later = expression.subs(t, t - delay)
    return later if expression.has(sympy.DiracDelta) else later * sympy.Heaviside(t - delay)


def term(value, t: sympy.Symbol, power: int = 0, rate=0, frequency=0, phase=0) -> sympy.Expr:
    """value t^power e^(rate t) cos(frequency t + phase)."""
    cosine = sympy.cos(frequency * t + phase) if frequency != 0 else sympy.cos(phase)
    return value * t**power * sympy.exp(rate * t) * cosine


def power_input(value, t: sympy.Symbol, gamma: int) -> sympy.Expr:
    """value I_gamma: t^(gamma-1)/(gamma-1)!, for gamma <= 0 a derivative of Dirac's delta."""
    if gamma <= 0:
        return value * delta(t, -gamma)
    return value * t ** (gamma - 1) / sympy.factorial(gamma - 1)


def pulse(value, t: sympy.Symbol, start, duration) -> sympy.Expr:
    """A constant for some time, zero before and after."""
    end = start + duration
    return value * ((sympy.Heaviside(t - start) if start != 0 else sympy.S.One) - sympy.Heaviside(t - end))


def sampled(times: Sequence, values: Sequence, t: sympy.Symbol) -> sympy.Expr:
    """Linear between samples, zero outside."""
    if len(times) > MOST_SAMPLES:
        raise InputError(f"a record of {len(times)} samples makes no formula that can be read; expected at most {MOST_SAMPLES}")
    total = sympy.S.Zero
    for start, end, first, last in zip(times, times[1:], values, values[1:]):
        if end != start:
            line = first + (last - first) / (end - start) * (t - start)
            total += sympy.expand(line) * (sympy.Heaviside(t - start) - sympy.Heaviside(t - end))
    return total


def angle(radians: sympy.Expr) -> sympy.Expr:
    """A phase; a decimal that is a whole number of degrees but for its rounding is that."""
    if not radians.is_Rational or radians == 0:
        return radians
    degrees = sympy.Integer(round(radians * 180 / sympy.pi.evalf(40)))
    exact = degrees * sympy.pi / 180
    return exact if abs((radians - exact).evalf(40)) <= abs(radians) * sympy.Float(2) ** -51 else radians


# Conditions on the start in the values at 0- that a user gives: those of inputs and outputs follow from the others.


def without_implied(
    form: ClosedForm, x: SymbolicResponse, implied: Mapping[str, Mapping[str, sympy.Expr]]
) -> dict[str, tuple[sympy.Eq, ...]]:
    """The admissible and continuous conditions without values that follow from others; none where the input jumps, which is reported itself."""
    if not implied:
        return {}
    values, names = initial_symbols(x.polynomial_matrix), x.coordinates
    put = {
        row[names.index(name)]: sum((factor * row[names.index(other)] for other, factor in factors.items()), sympy.S.Zero)
        for name, factors in implied.items()
        for row in values.tolist()
    }
    given = [value for value in values if value not in put]
    return {kind: _solved([each.xreplace(put) for each in getattr(form, kind)], given) for kind in ("admissible", "continuous")}


def _solved(equations: Sequence[sympy.Eq], values: Sequence[sympy.Symbol]) -> tuple[sympy.Eq, ...]:
    """Linear equations solved for the earliest of the values; none of them where they contradict each other."""
    left = [sympy.expand(each.lhs - each.rhs) if isinstance(each, sympy.Eq) else 0 if each else 1 for each in equations]
    if not any(left) or not values:
        return ()
    A, b = sympy.linear_eq_to_matrix(left, values)
    reduced, pivots = DomainMatrix.from_Matrix(A.row_join(b)).to_field().rref()
    if len(values) in pivots:
        return ()
    solved = []
    for row, pivot in zip(reduced.to_Matrix().tolist(), pivots):
        rest = [-factor * value for place, (factor, value) in enumerate(zip(row, values)) if place != pivot]
        solved.append(sympy.Eq(values[pivot], sympy.Add(sympy.factor(row[-1]), *rest), evaluate=False))
    return tuple(solved)
