"""The planar linkages once more, by SymPy: Lagrange's equations with multipliers and its own linearizer.

In contrast to linkages.py the loops stay equations here: LagrangesMethod with holonomic constraints, linearized about
the posture of linkages.json with the multipliers that belong to it. ``python tests/oracles/linkages_sympy.py`` writes
linkages_sympy.json (6 s); tests/oracles/test_linkages.py compares the two.
"""

from __future__ import annotations

import json
from pathlib import Path

from mpmath import eig, matrix, mp
from sympy import Float, Rational, cos, sin, symbols
from sympy.physics.mechanics import LagrangesMethod, ReferenceFrame, dynamicsymbols

HERE = Path(__file__).parent
TABLE = json.loads((HERE / "linkages.json").read_text())
DIGITS = 50
g = Rational(981, 100)
t = symbols("t")
mp.dps = DIGITS


def exact(value):
    return [exact(x) for x in value] if isinstance(value, list) else Rational(str(value))


def bar(mass, length, x, y, angle):
    """(kinetic, potential) energy of a uniform bar from (x, y), and its tip."""
    u, v = x + length * cos(angle) / 2, y + length * sin(angle) / 2
    kinetic = mass * (u.diff(t) ** 2 + v.diff(t) ** 2) / 2 + mass * length**2 * angle.diff(t) ** 2 / 24
    return kinetic, mass * g * v, (x + length * cos(angle), y + length * sin(angle))


def chain(p, q, x=0, y=0):
    """Bars one after another, relative angles."""
    parts, angle = [], 0
    for m, length, turn in zip(exact(p["masses"]), exact(p["lengths"]), q):
        angle = angle + turn
        kinetic, potential, (x, y) = bar(m, length, x + 0 * turn, y + 0 * turn, angle)
        parts.append((kinetic, potential))
    return parts, (x, y)


def four_bar(p, q):
    parts, end = chain({"masses": p["masses"][:2], "lengths": p["lengths"][:2]}, q[:2])
    kinetic, potential, tip = bar(*exact([p["masses"][2], p["lengths"][2], p["base"]]), 0 * q[2], q[2])
    spring = exact(p["stiffness"]) * (q[0] - exact(p["rest"])) ** 2 / 2
    return [*parts, (kinetic, potential), (0, spring)], [end[0] - tip[0], end[1] - tip[1]]


def hanging_four_bar(p, q):
    parts, end = chain(p, q)
    return parts, [end[0] - exact(p["end"][0]), end[1] - exact(p["end"][1])]


def slider_crank(p, q):
    parts, end = chain({"masses": p["masses"][:2], "lengths": p["lengths"][:2]}, q[:2])
    slide = exact(p["masses"][2]) * q[2].diff(t) ** 2 / 2
    spring = exact(p["stiffness"]) * (q[2] - exact(p["rest"])) ** 2 / 2
    return [*parts, (slide, spring)], [end[0] - q[2], end[1] - exact(p["height"])]


def frequency(build, name):
    """The one oscillation of the linearized equations."""
    p, known = TABLE[name]["given"], TABLE[name]["known"]
    q = dynamicsymbols("q1:4")
    parts, loops = build(p, q)
    L = sum(kinetic for kinetic, _ in parts) - sum(potential for _, potential in parts)
    method = LagrangesMethod(L, q, hol_coneqs=loops, frame=ReferenceFrame("N"))
    equations = method.form_lagranges_equations()
    rates, accelerations = [x.diff(t) for x in q], [x.diff(t, 2) for x in q]
    rest = dict.fromkeys([*accelerations, *rates], 0)
    point = {x: Float(value, DIGITS) for x, value in zip(q, known["posture"].values())}
    balance = equations.subs(dict.fromkeys(accelerations, 0)).subs(dict.fromkeys(rates, 0)).subs(point)
    lam = list(method.lam_vec)
    J = balance.jacobian(lam)
    free = balance.subs(dict.fromkeys(lam, 0))
    pulls = dict(zip(lam, (J.T * J).LUsolve(-J.T * free)))
    assert max(abs(x) for x in balance.subs(pulls)) < 1e-28, "this is not an equilibrium"
    linearizer = method.to_linearizer(q_ind=[q[0]], qd_ind=[rates[0]], q_dep=q[1:], qd_dep=rates[1:])
    A, _ = linearizer.linearize(op_point=[rest, {**point, **pulls}], A_and_B=True)
    A = A.subs(pulls).subs(rest).subs(point).evalf(DIGITS)
    values, _ = eig(matrix([[mp.mpf(str(x)) for x in A.row(i)] for i in range(A.rows)]))
    return max(abs(s.imag) for s in values)


CASES = {
    "four-bar": four_bar,
    "trapezoid": hanging_four_bar,
    "skew hanging four-bar": hanging_four_bar,
    "slider-crank": slider_crank,
}


def main():
    found = {name: mp.nstr(frequency(build, name), 32) for name, build in CASES.items()}
    (HERE / "linkages_sympy.json").write_text(json.dumps(found, indent=1) + "\n")
    print(found, {name: TABLE[name]["known"]["angular_frequencies"] for name in found})


if __name__ == "__main__":
    main()
