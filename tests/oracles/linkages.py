"""Linkages in minimal coordinates, to 30 digits: the referee of the robots. It shares nothing with the package.

Every linkage below is written down by hand: where its bodies are as a function of a few coordinates, which of them follow
from the others by closing the loops (Newton in 80 digits), and its potential energy V. No multiplier, no Jacobian of a
loop and no geometric stiffness occurs: the loops are solved, and with z the independent coordinates

    K = d^2 V / dz^2,   M = sum m (dp/dz)^T (dp/dz) + w^T I w,   C = sum c (du/dz)^T (du/dz)

by central differences (step 1e-20 in 80 digits: 1e-38). Written by ``python tests/oracles/linkages.py`` into linkages.json
beside the numbers that define each linkage ("given"), from which the tests build the URDF. Closed forms and SymPy's
``LagrangesMethod`` (linkages_sympy.py) check the generator itself.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from mpmath import cholesky, cos, diag, eig, eigsy, eye, inverse, lu_solve, matrix, mp, mpf, pi, sin, sqrt, zeros

FILE = Path(__file__).with_name("linkages.json")
STEP = mpf(10) ** -20
mp.dps = 80
g = mpf("9.81")


@dataclass
class Body:
    """Mass, inertia about its centre in its own axes (3 x 3), place of the centre, rotation to the world."""

    mass: object
    inertia: object
    place: object
    rotation: object


@dataclass
class Linkage:
    """Independent and dependent coordinates (in this order), loops, bodies, potential (without weight), dampers, posture."""

    names: list
    guess: list
    bodies: object
    closure: object = None
    potential: object = lambda q: 0
    dampers: tuple = ()
    gravity: tuple = (0, -g, 0)
    held: bool = False

    @property
    def free(self):
        return len(self.guess) - (len(self.closure(self.guess)) if self.closure else 0)

    def closed(self, z):
        """All coordinates, the dependent ones by Newton from the guess."""
        z, rest = list(z), [mpf(x) for x in self.guess[self.free :]]
        for _ in range(60):
            if not rest:
                break
            error = matrix(self.closure(z + rest))
            slope = columns(lambda y: matrix(self.closure(z + list(y))), rest)
            step = lu_solve(slope, error)
            rest = [x - s for x, s in zip(rest, step)]
            if max(abs(s) for s in step) < mpf(10) ** -35:
                break
        else:
            raise ValueError("this loop does not close")
        return z + rest

    def energy(self, z):
        return self.energy_of(self.closed(z))

    def energy_of(self, q):
        weight = -sum(b.mass * sum(a * x for a, x in zip(self.gravity, b.place)) for b in self.bodies(q))
        return weight + self.potential(q)

    def equilibrium(self):
        z = [mpf(x) for x in self.guess[: self.free]]
        for _ in range(0 if self.held else 60):
            step = lu_solve(hessian(self.energy, z), matrix([slope(self.energy, z, i) for i in range(len(z))]))
            z = [x - s for x, s in zip(z, step)]
            if max(abs(s) for s in step) < mpf(10) ** -33:
                break
        return z

    def mass(self, z):
        at = [self.bodies(self.closed(shifted(z, i, s))) for i in range(len(z)) for s in (STEP, -STEP)]
        now = self.bodies(self.closed(z))
        M = zeros(len(z))
        for k, body in enumerate(now):
            moves, turns = [], []
            for i in range(len(z)):
                up, down = at[2 * i][k], at[2 * i + 1][k]
                moves.append((matrix(up.place) - matrix(down.place)) / (2 * STEP))
                W = body.rotation.T * (up.rotation - down.rotation) / (2 * STEP)
                turns.append(matrix([W[2, 1], W[0, 2], W[1, 0]]))
            for i in range(len(z)):
                for j in range(len(z)):
                    M[i, j] += body.mass * (moves[i].T * moves[j])[0] + (turns[i].T * body.inertia * turns[j])[0]
        return M

    def damping(self, z):
        C = zeros(len(z))
        for value, rate in self.dampers:
            u = [slope(lambda y, rate=rate: rate(self.closed(y)), z, i) for i in range(len(z))]
            for i in range(len(z)):
                for j in range(len(z)):
                    C[i, j] += value * u[i] * u[j]
        return C

    def loop_forces(self, z):
        """What stands in J^T lambda = grad V, J the gradient of ``closure`` in all coordinates."""
        q = self.closed(z)
        rest = range(self.free, len(q))
        gradient = matrix([slope(self.energy_of, q, i) for i in rest])
        J = columns(lambda y: matrix(self.closure(q[: self.free] + list(y))), q[self.free :])
        return list(lu_solve(J.T, gradient))


def shifted(z, i, step):
    return [x + (step if k == i else 0) for k, x in enumerate(z)]


def slope(f, z, i):
    return (f(shifted(z, i, STEP)) - f(shifted(z, i, -STEP))) / (2 * STEP)


def columns(f, z):
    return joined([slope(f, z, i) for i in range(len(z))])


def joined(vectors):
    J = zeros(len(vectors[0]), len(vectors))
    for j, vector in enumerate(vectors):
        for i, x in enumerate(vector):
            J[i, j] = x
    return J


def hessian(f, z):
    n, H, middle = len(z), zeros(len(z)), f(z)
    for i in range(n):
        H[i, i] = (f(shifted(z, i, STEP)) - 2 * middle + f(shifted(z, i, -STEP))) / STEP**2
        for j in range(i):
            corners = [f(shifted(shifted(z, i, a * STEP), j, b * STEP)) * a * b for a in (1, -1) for b in (1, -1)]
            H[i, j] = H[j, i] = sum(corners) / (4 * STEP**2)
    return H


def frequencies(M, K):
    """Angular frequencies, ascending; 0 for rigid modes."""
    L = inverse(cholesky(M))
    values = eigsy(L * K * L.T, eigvals_only=True)
    assert min(values) > -(mpf(10) ** -30), "this posture is not stable: no frequency belongs to it"
    return sorted(sqrt(x) if x > mpf(10) ** -30 else mpf(0) for x in values)


def finite_zeros(M, C, K):
    n = len(M)
    A = zeros(2 * n)
    A[:n, n:] = eye(n)
    A[n:, :n], A[n:, n:] = -inverse(M) * K, -inverse(M) * C
    values, _ = eig(A)
    return sorted(values, key=lambda s: (s.imag, s.real))


def rotation(axis, angle):
    c, s = cos(angle), sin(angle)
    turn = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return matrix(turn[axis])


def rotated_by(v):
    """Rodrigues' formula for a rotation vector; in 80 digits the quotients keep 40 down to a step of 1e-20."""
    S = matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    angle = sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    return eye(3) + (S * sin(angle) / angle + S * S * (1 - cos(angle)) / angle**2 if angle else zeros(3))


def planar(mass, inertia, x, y, angle):
    """A body that moves in the x-y plane; only its inertia about z counts."""
    return Body(mass, inertia * eye(3), (x, y, mpf(0)), rotation("z", angle))


def bar(mass, length, x, y, angle):
    """A uniform bar that starts at (x, y)."""
    return planar(mass, mass * length**2 / 12, x + length / 2 * cos(angle), y + length / 2 * sin(angle), angle)


def tip(x, y, length, angle):
    return x + length * cos(angle), y + length * sin(angle)


def number(value):
    """A given number as mpf: exactly the decimal that the tests read."""
    if isinstance(value, dict):
        return {key: number(x) for key, x in value.items()}
    return [number(x) for x in value] if isinstance(value, (list, tuple)) else mpf(str(value))


# ---------------------------------------------------------------- planar linkages: x-y plane, weight along -y


def double_pendulum(p):
    def bodies(q):
        x, y = tip(0, 0, p["lengths"][0], q[0])
        return [bar(p["masses"][0], p["lengths"][0], mpf(0), mpf(0), q[0]), bar(p["masses"][1], p["lengths"][1], x, y, q[0] + q[1])]

    def potential(q):
        return sum(k * (x - r) ** 2 for k, x, r in zip(p["stiffness"], q, p["rest"])) / 2

    dampers = tuple((c, lambda q, i=i: q[i]) for i, c in enumerate(p["damping"]))
    return Linkage(["j1", "j2"], p["guess"], bodies, potential=potential, dampers=dampers)


def four_bar(p):
    """j1 crank, j2 coupler (relative), j3 rocker; the tips of coupler and rocker are joined. A pin body may turn with the rocker."""
    crank, coupler, rocker = p["lengths"]

    def ends(q):
        x, y = tip(0, 0, crank, q[0])
        return (x, y), tip(x, y, coupler, q[0] + q[1]), tip(p["base"], 0, rocker, q[2])

    def bodies(q):
        (x, y), _, (u, v) = ends(q)
        found = [bar(p["masses"][0], crank, mpf(0), mpf(0), q[0]), bar(p["masses"][1], coupler, x, y, q[0] + q[1])]
        found.append(bar(p["masses"][2], rocker, p["base"], mpf(0), q[2]))
        if "pin_mass" in p:
            found.append(planar(p["pin_mass"], p["pin_inertia"], *tip(u, v, p["pin_offset"], q[2]), q[2]))
        return found

    def closure(q):
        _, a, b = ends(q)
        return [a[0] - b[0], a[1] - b[1]]

    def potential(q):
        return p["stiffness"] * (q[0] - p["rest"]) ** 2 / 2

    dampers = tuple((c, lambda q, i=i: q[i]) for i, c in enumerate(p.get("damping", ())))
    return Linkage(["j1", "j2", "j3"], p["guess"], bodies, closure, potential, dampers)


def hanging_four_bar(p):
    """A chain j1, j2, j3 (relative angles) between two points of a ceiling: trapezoid and others; weight only."""
    lengths = p["lengths"]

    def places(q):
        x, y, angle, found = mpf(0), mpf(0), mpf(0), []
        for length, turn in zip(lengths, q):
            angle += turn
            found.append((x, y, angle))
            x, y = tip(x, y, length, angle)
        return found, (x, y)

    def bodies(q):
        return [bar(m, length, *place) for m, length, place in zip(p["masses"], lengths, places(q)[0])]

    def closure(q):
        x, y = places(q)[1]
        return [x - p["end"][0], y - p["end"][1]]

    return Linkage(["j1", "j2", "j3"], p["guess"], bodies, closure)


def slider_crank(p):
    """j1 crank, j2 rod (relative), slide along x with a spring; the rod's tip is joined to the slider."""
    crank, rod = p["lengths"]

    def bodies(q):
        x, y = tip(0, 0, crank, q[0])
        first, second = (bar(p["masses"][0], crank, mpf(0), mpf(0), q[0]), bar(p["masses"][1], rod, x, y, q[0] + q[1]))
        return [first, second, planar(p["masses"][2], mpf(1), q[2], p["height"], mpf(0))]

    def closure(q):
        x, y = tip(*tip(0, 0, crank, q[0]), rod, q[0] + q[1])
        return [x - q[2], y - p["height"]]

    def potential(q):
        return p["stiffness"] * (q[2] - p["rest"]) ** 2 / 2

    dampers = ((p["damping"], lambda q: q[2]),)
    return Linkage(["j1", "j2", "slide"], p["guess"], bodies, closure, potential, dampers)


def six_bar(p):
    """Stephenson III: a four-bar whose coupler carries, at a point off its line, a dyad j4 (relative), j5 to the ground."""
    crank, coupler, rocker, link, arm = p["lengths"]

    def ends(q):
        a = tip(0, 0, crank, q[0])
        angle = q[0] + q[1]
        b = tip(*a, coupler, angle)
        c = tip(p["base"], 0, rocker, q[2])
        along, across = p["coupler_point"]
        d = (a[0] + along * cos(angle) - across * sin(angle), a[1] + along * sin(angle) + across * cos(angle))
        e, f = tip(*d, link, angle + q[3]), tip(*p["second_base"], arm, q[4])
        return a, b, c, d, e, f

    def bodies(q):
        a, _, _, d, _, _ = ends(q)
        angle = q[0] + q[1]
        starts = [(mpf(0), mpf(0), q[0]), (*a, angle), (p["base"], mpf(0), q[2]), (*d, angle + q[3]), (*p["second_base"], q[4])]
        return [bar(m, length, *start) for m, length, start in zip(p["masses"], p["lengths"], starts)]

    def closure(q):
        _, b, c, _, e, f = ends(q)
        return [b[0] - c[0], b[1] - c[1], e[0] - f[0], e[1] - f[1]]

    def potential(q):
        return (p["stiffness"][0] * (q[0] - p["rest"][0]) ** 2 + p["stiffness"][1] * (q[4] - p["rest"][1]) ** 2) / 2

    return Linkage(["j1", "j2", "j3", "j4", "j5"], p["guess"], bodies, closure, potential)


def strut(p):
    """A double pendulum whose second bar hangs on a line spring of given rest length from a point of the ground."""

    def bodies(q):
        return double_pendulum({**p, "stiffness": [0, 0], "rest": [0, 0], "damping": [0, 0]}).bodies(q)

    def length(q):
        x, y = tip(*tip(0, 0, p["lengths"][0], q[0]), p["along"], q[0] + q[1])
        return sqrt((x - p["anchor"][0]) ** 2 + (y - p["anchor"][1]) ** 2)

    def potential(q):
        return p["spring"] * (length(q) - p["rest_length"]) ** 2 / 2

    return Linkage(["j1", "j2"], p["guess"], bodies, potential=potential, dampers=((p["damping"], length),))


# ---------------------------------------------------------------- spatial linkages: weight along -z


def spatial_loop(p):
    """RUSR: crank about z, rod on a universal joint (y then z of the crank's end), ball at the tip of a rocker about x."""
    crank, rod, rocker = p["lengths"]
    base = matrix(p["base"])

    def turned(q):
        first = rotation("z", q[0])
        return (first, first * rotation("y", q[1]) * rotation("z", q[2]), rotation("x", q[3]))

    def bar_of(mass, length, start, R, inertia):
        axes = diag([inertia, *[mass * length**2 / 12] * 2])
        return Body(mass, axes, start + R * matrix([length / 2, 0, 0]), R)

    def bodies(q):
        R1, R2, R3 = turned(q)
        first = bar_of(p["masses"][0], crank, matrix([0, 0, 0]), R1, p["spin"])
        second = bar_of(p["masses"][1], rod, R1 * matrix([crank, 0, 0]), R2, p["spin"])
        across = p["masses"][2] * rocker**2 / 12
        axes = diag([across, p["spin"], across])
        return [first, second, Body(p["masses"][2], axes, base + R3 * matrix([0, rocker / 2, 0]), R3)]

    def closure(q):
        R1, R2, R3 = turned(q)
        return list(R1 * matrix([crank, 0, 0]) + R2 * matrix([rod, 0, 0]) - base - R3 * matrix([0, rocker, 0]))

    def potential(q):
        return p["stiffness"] * (q[0] - p["rest"]) ** 2 / 2

    return Linkage(["j1", "u1", "u2", "j4"], p["guess"], bodies, closure, potential, gravity=(0, 0, -g))


def spherical(p):
    """Four hinges whose axes meet in the origin. In a link's axes the next hinge is its z turned about its x by the arc."""
    arc1, arc2, arc3, arc4 = p["arcs"]
    masses, inertias, place = p["masses"], p["inertias"], matrix(p["centre"])

    def turned(q):
        first = rotation("z", q[0])
        second = first * rotation("x", arc1) * rotation("z", q[1])
        third = rotation("x", arc4) * rotation("z", q[2])
        return first, second, third

    def bodies(q):
        return [Body(m, i * eye(3), R * place, R) for m, i, R in zip(masses, inertias, turned(q))]

    def closure(q):
        _, second, third = turned(q)
        end, other = (second * rotation("x", arc2) * matrix([0, 0, 1]), third * rotation("x", arc3) * matrix([0, 0, 1]))
        gap = end - other
        return [gap[0], gap[1]]

    def potential(q):
        return p["stiffness"] * (q[0] - p["rest"]) ** 2 / 2

    return Linkage(["j1", "j2", "j3"], p["guess"], bodies, closure, potential, gravity=(0, 0, -g))


def free_pendulum(p):
    """A body that floats without weight and carries a bar on a hinge with a spring: six rigid modes and one frequency."""
    place, length = matrix(p["hinge"]), p["length"]
    base, axes = diag(p["base_inertia"]), diag([p["spin"], *[p["mass"] * length**2 / 12] * 2])

    def bodies(q):
        R = rotated_by(q[3:6])
        x = matrix(q[:3])
        turn = R * rotation("y", q[6])
        centre = x + R * place + turn * matrix([length / 2, 0, 0])
        return [Body(p["base_mass"], base, x, R), Body(p["mass"], axes, centre, turn)]

    def potential(q):
        return p["stiffness"] * (q[6] - p["angle"]) ** 2 / 2

    names = [f"base {x}" for x in ("x", "y", "z", "rx", "ry", "rz")] + ["j1"]
    return Linkage(names, [0] * 6 + [p["angle"]], bodies, potential=potential, gravity=(0, 0, 0), held=True)


def platform(p):
    """A free body on line springs to the ground with given rest lengths, under its weight: six frequencies."""
    axes = diag(p["inertia"])

    def bodies(q):
        return [Body(p["mass"], axes, matrix(q[:3]), rotated_by(q[3:6]))]

    def potential(q):
        R, x = rotated_by(q[3:6]), matrix(q[:3])
        total = mpf(0)
        for spring in p["springs"]:
            d = x + R * matrix(spring["on_body"]) - matrix(spring["on_ground"])
            total += spring["stiffness"] * (sqrt((d.T * d)[0]) - spring["rest_length"]) ** 2 / 2
        return total

    names = [f"base {x}" for x in ("x", "y", "z", "rx", "ry", "rz")]
    return Linkage(names, p["guess"], bodies, potential=potential, gravity=(0, 0, -g))


def bushing(p):
    """A free body on one bushing off its centre, sunk by its weight; the bushing's axes are the ground's and stay so."""
    axes = diag(p["inertia"])

    def bodies(q):
        return [Body(p["mass"], axes, matrix(q[:3]), rotated_by(q[3:6]))]

    def potential(q):
        d = matrix(q[:3]) + rotated_by(q[3:6]) * matrix(p["on_body"]) - matrix(p["on_body"])
        push = p["stiffness"] * (d.T * d)[0]
        return (push + sum(k * x**2 for k, x in zip(p["turning_stiffness"], q[3:6]))) / 2

    names = [f"base {x}" for x in ("x", "y", "z", "rx", "ry", "rz")]
    return Linkage(names, [0] * 6, bodies, potential=potential, gravity=(0, 0, -g))


def taut_string(p):
    """A point on two preloaded springs along x, sagging under its weight along z."""

    def bodies(q):
        return [Body(p["mass"], zeros(3), matrix(q), eye(3))]

    def potential(q):
        total = mpf(0)
        for side in (-1, 1):
            length = sqrt((q[0] - side * p["half_span"]) ** 2 + q[1] ** 2 + q[2] ** 2)
            total += p["stiffness"] * (length - p["rest_length"]) ** 2 / 2
        return total

    return Linkage(["x", "y", "z"], p["guess"], bodies, potential=potential, gravity=(0, 0, -p["gravity"]))


def flexible_arm(p):
    """The double pendulum, each joint driven through a spring by a motor with inertia and PD; held where it is by torques."""
    arm = double_pendulum({**p, "stiffness": [0, 0], "rest": [0, 0], "damping": [0, 0]})
    held = [slope(arm.energy_of, p["guess"], i) for i in range(2)]
    K, B, Kp = (p["flexibility"], [j * n**2 for j, n in zip(p["motor_inertia"], p["gear_ratio"])], p["proportional_gain"])
    motor = [q + h / k for q, h, k in zip(p["guess"], held, K)]

    def bodies(q):
        rotors = [Body(mpf(0), b * eye(3), matrix([0, 0, 0]), rotation("z", x)) for b, x in zip(B, q[2:])]
        return arm.bodies(q[:2]) + rotors

    def potential(q):
        twist = sum(k * (x - m) ** 2 for k, x, m in zip(K, q[:2], q[2:])) / 2
        gains = sum(k * (m - m0) ** 2 / 2 - h * m for k, m, m0, h in zip(Kp, q[2:], motor, held))
        return twist + gains

    dampers = [(c, lambda q, i=i: q[i] - q[2 + i]) for i, c in enumerate(p["flexible_damping"])]
    dampers += [(c, lambda q, i=i: q[2 + i]) for i, c in enumerate(p["derivative_gain"])]
    names = ["j1", "j2", "j1 motor", "j2 motor"]
    return Linkage(names, [*p["guess"], *motor], bodies, potential=potential, dampers=tuple(dampers), held=True)


# ---------------------------------------------------------------- the table: numbers that define each linkage, and the results

BUILDERS = {
    "double pendulum": double_pendulum,
    "four-bar": four_bar,
    "four-bar with dampers": four_bar,
    "four-bar with a pin": four_bar,
    "trapezoid": hanging_four_bar,
    "skew hanging four-bar": hanging_four_bar,
    "slider-crank": slider_crank,
    "six-bar": six_bar,
    "strut": strut,
    "spatial loop": spatial_loop,
    "spherical four-bar": spherical,
    "pendulum on a floating body": free_pendulum,
    "platform on springs": platform,
    "sunk bushing": bushing,
    "standing bushing": bushing,
    "taut string": taut_string,
    "sagging string": taut_string,
    "flexible arm": flexible_arm,
    "flexible arm with PD": flexible_arm,
}
TABLE = json.loads(FILE.read_text())


def linkage(name):
    """The linkage from the numbers in the table."""
    return BUILDERS[name](number(TABLE[name]["given"]))


def digits(x):
    return mp.nstr(mp.chop(x, tol=mpf(10) ** -33) if not isinstance(x, mpf) else x, 32)


def known(linkage):
    """Everything the tests ask, as decimal strings."""
    z = linkage.equilibrium()
    q, M, K = linkage.closed(z), linkage.mass(z), hessian(linkage.energy, z)
    found = {
        "posture": dict(zip(linkage.names, (digits(x) for x in q))),
        "angular_frequencies": [digits(x) for x in frequencies(M, K)],
        "potential_energy": digits(linkage.energy(z)),
    }
    if linkage.dampers:
        found["zeros"] = [[digits(s.real), digits(s.imag)] for s in finite_zeros(M, linkage.damping(z), K)]
    if linkage.closure:
        found["loop_forces"] = [digits(x) for x in linkage.loop_forces(z)]
    return found


def closed_forms():
    """The generator against formulas that need none of it."""
    p = number(TABLE["taut string"]["given"])
    tension = p["stiffness"] * (p["half_span"] - p["rest_length"])
    found = known(linkage("taut string"))["angular_frequencies"]
    for value, formula in zip(found, [2 * tension / p["half_span"]] * 2 + [2 * p["stiffness"]]):
        assert abs(mpf(value) ** 2 - formula / p["mass"]) < mpf(10) ** -28
    length, mass, crank = mpf("0.5"), mpf("1.5"), mpf("0.4")
    given = {
        "masses": [crank, mass, crank],
        "lengths": [length, mpf(1), length],
        "end": [mpf(1), mpf(0)],
        "guess": [-pi / 2 + mpf("0.1"), pi / 2, pi / 2],
    }
    w2 = g * (mass * length + crank * length) / (mass * length**2 + crank * length**2 * 2 / 3)
    assert abs(mpf(known(hanging_four_bar(given))["angular_frequencies"][0]) ** 2 - w2) < mpf(10) ** -28


def main():
    closed_forms()
    for name, entry in TABLE.items():
        entry["known"] = known(linkage(name))
        print(name, entry["known"]["posture"], [x[:12] for x in entry["known"]["angular_frequencies"]])
    FILE.write_text(json.dumps(TABLE, indent=1) + "\n")


if __name__ == "__main__":
    main()
