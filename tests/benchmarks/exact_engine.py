"""What exact answers cost, after imports: symbolic examples, structure and chains over the rationals, enclosures.

    python tests/benchmarks/exact_engine.py [repetitions]

Prints medians in seconds and, where the numeric engine answers the same question, the ratio to its time in the same process.
"""

import statistics
import sys
import time
from collections.abc import Callable

import numpy as np
import sympy

import mbconstrained as mb
from mbconstrained.exact.enclosure.exact_response import exact_response
from tests.oracles.referee import NAMES, case

ZERO = sympy.zeros(3, 3)


def main(repetitions: int) -> None:
    print(f"{'question':58s} {'seconds':>9s} {'exact / numeric':>16s}")
    for name, exact, numeric in questions():
        own = median(exact, repetitions)
        ratio = f"{own / median(numeric, repetitions):16.2f}" if numeric else ""
        print(f"{name:58s} {own:9.3f} {ratio}")


def median(work: Callable[[], object], repetitions: int) -> float:
    """Seconds."""
    found = []
    for _ in range(repetitions):
        begun = time.process_time()
        work()
        found.append(time.process_time() - begun)
    return statistics.median(found)


def questions():
    """Name, exact answer, numeric answer or None."""
    yield (
        "5.1 with m, k: structure, pairs, response",
        lambda: whole(two_masses(), [[sympy.Rational(4, 5), sympy.Rational(6, 5), 2], [0] * 3]),
        None,
    )
    yield (
        "5.2 with m, k1, k2, c1, c2: structure, pairs, response",
        lambda: whole(massless_joints(), [[sympy.Rational(2, 3), 1, 2], [0] * 3]),
        None,
    )
    random = np.random.default_rng(0)
    kinds = (("whole numbers", lambda size: random.integers(-9, 10, size).astype(float)), ("float64", random.standard_normal))
    for kind, entries in kinds:
        A = entries((5, 40, 40))
        structure, pairs = (lambda A=A: mb.exact.structure(fresh(A))), (lambda A=A: chains(fresh(A)))
        yield f"structure, r = 40, q = 4, {kind}", structure, lambda A=A: fresh(A).structure()
        yield f"chains, both pairs but B, r = 40, q = 4, {kind}", pairs, lambda A=A: fresh(A).jordan_pairs().finite.J
    exact = [name for name in NAMES if not name.startswith("rot_")]
    problems = [case(name) for name in exact]
    for digits in (15, 100):
        yield (
            f"{len(exact)} referee problems to {digits} digits",
            lambda d=digits: enclosed(problems, d),
            lambda: numerically(problems),
        )


def whole(A: mb.SymbolicPolynomialMatrix, initial) -> None:
    """All that is asked of an example."""
    pairs = A.jordan_pairs()
    assert A.smith_form() and pairs.finite.B and pairs.infinite.J is not None and pairs.jump_projector and pairs.laurent(-2)
    x = mb.solve_symbolically(A, initial)
    assert x.expression and x.continuity_conditions is not None


def two_masses() -> mb.SymbolicPolynomialMatrix:
    """Moysis et al., section 5.1, at acceleration level."""
    m, k = sympy.symbols("m k", positive=True)
    V, M, K = sympy.Matrix([[1, 0], [1, 0], [0, 1]]), sympy.Matrix([[m, 0, 0], [0, m, m], [0, m, m]]), sympy.diag(k, 0, k)
    return mb.SymbolicPolynomialMatrix(
        [(V.T * K).col_join(sympy.zeros(1, 3)), ZERO, (V.T * M).col_join(sympy.Matrix([[1, -1, 0]]))]
    )


def massless_joints() -> mb.SymbolicPolynomialMatrix:
    """Moysis et al., section 5.2."""
    m, k1, k2, c1, c2 = sympy.symbols("m k1 k2 c1 c2", positive=True)
    K = [[k1 + k2, 0, -k2], [0, 0, 0], [-k2, 0, k2]]
    C = [[0, 0, 0], [0, c1 + c2, -c2], [0, -c2, c2]]
    return mb.SymbolicPolynomialMatrix([K, C, sympy.diag(0, 0, m)])


def fresh(A) -> mb.PolynomialMatrix:
    """Without what an earlier question has left in it."""
    return mb.PolynomialMatrix(A)


def chains(A: mb.PolynomialMatrix) -> None:
    """Both pairs, without the B of one long irreducible factor."""
    pairs = mb.exact.jordan_pairs(A)
    assert (
        all(chain.vectors for chain in pairs.chains)
        and pairs.finite.J.size
        and pairs.finite.C.size
        and pairs.infinite.C is not None
    )


def enclosed(problems, digits: int) -> None:
    for given in problems:
        exact_response(mb.PolynomialMatrix(given.coefficients), given.initial, given.force).enclose(given.times, digits)


def numerically(problems) -> None:
    for given in problems:
        mb.solve(mb.PolynomialMatrix(given.coefficients), given.initial, given.force)(given.times)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
