"""URDF texts of small linkages and the robots made of them, from the numbers in tests/oracles/linkages.json."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import mbconstrained as mb
from tests.robot.reference import Reference

ORACLES = Path(__file__).parents[1] / "oracles"
TABLE = json.loads((ORACLES / "linkages.json").read_text())
PLANE = (0.0, -9.81, 0.0)


def given(name: str) -> dict:
    """The numbers that define a linkage."""
    return TABLE[name]["given"]


def known(name: str) -> dict:
    """What tests/oracles/linkages.py found for it: 30 digits, minimal coordinates."""
    return TABLE[name]["known"]


def known_frequencies(name: str) -> np.ndarray:
    return np.array([float(x) for x in known(name)["angular_frequencies"]])


def text(vector) -> str:
    return " ".join(repr(float(x)) for x in vector)


def link(name: str, mass=None, centre=(0, 0, 0), inertia=(0, 0, 0), turned=(0, 0, 0)) -> str:
    """A link; inertia about its centre: ixx, iyy, izz (, ixy, ixz, iyz) in axes turned by roll, pitch, yaw."""
    if mass is None:
        return f'<link name="{name}"/>'
    values = dict(zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), [*inertia, 0, 0, 0]))
    entries = " ".join(f'{key}="{float(x)!r}"' for key, x in values.items())
    place = f'<origin xyz="{text(centre)}" rpy="{text(turned)}"/>'
    return f'<link name="{name}"><inertial>{place}<mass value="{float(mass)!r}"/><inertia {entries}/></inertial></link>'


def bar(name: str, mass: float, length: float, spin: float = 1e-3) -> str:
    """A uniform bar along x of its link, from its origin."""
    across = mass * length**2 / 12
    return link(name, mass, (length / 2, 0, 0), (spin, across, across))


def joint(
    name, parent, child, kind="revolute", at=(0, 0, 0), turned=(0, 0, 0), axis=(0, 0, 1), limits=(-1e6, 1e6), damping=0.0
) -> str:
    """A joint; limits are left out for kinds that have none."""
    limit = (
        f'<limit lower="{limits[0]}" upper="{limits[1]}" effort="1e9" velocity="1e9"/>' if kind in ("revolute", "prismatic") else ""
    )
    dynamics = f'<dynamics damping="{float(damping)!r}"/>' if damping else ""
    places = f'<origin xyz="{text(at)}" rpy="{text(turned)}"/><parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{places}<axis xyz="{text(axis)}"/>{limit}{dynamics}</joint>'


def urdf(*parts: str, name: str = "linkage") -> str:
    """The text of a robot."""
    return f'<robot name="{name}">{"".join(parts)}</robot>'


GROUND = link("frame")


@dataclass
class Linkage:
    """A robot as text and options, and where to look for its posture; ``robot, guess = linkage`` makes it."""

    text: str
    options: dict
    guess: dict

    def __iter__(self):
        return iter((mb.Robot(self.text, **self.options), self.guess))

    def reference(self) -> Reference:
        """The same for the referee."""
        options = {key: tuple(value) if key in ("loops", "springs") else value for key, value in self.options.items()}
        gravity = options.get("gravity", (0.0, 0.0, -9.81))
        return Reference(self.text, **(options | {"gravity": (0, 0, -gravity) if np.isscalar(gravity) else gravity}))


def linkage(text: str, guess: dict, **options) -> Linkage:
    """A linkage with the options of its robot."""
    return Linkage(text, options, guess)


def start(p, names: str) -> dict:
    """The guess by joint."""
    return dict(zip(names.split(), p["guess"]))


def spring(p, name="j1") -> dict:
    """The spring of a joint with its rest."""
    return {"joint_stiffness": {name: p["stiffness"]}, "joint_rest": {name: p["rest"]}}


# ---------------------------------------------------------------- the linkages of the table: robot, guess, what to hold


def double_pendulum(p, springs=(), kind="revolute", **options):
    first, second = p["lengths"]
    damping = p.get("damping", (0, 0)) if not springs else (0, 0)
    model = urdf(
        GROUND,
        bar("upper", p["masses"][0], first),
        bar("lower", p["masses"][1], second),
        joint("j1", "frame", "upper", kind, damping=damping[0]),
        joint("j2", "upper", "lower", kind, at=(first, 0, 0), damping=damping[1]),
    )
    if "rest" in p:
        options |= {"joint_stiffness": dict(zip(("j1", "j2"), p["stiffness"])), "joint_rest": dict(zip(("j1", "j2"), p["rest"]))}
    return linkage(model, start(p, "j1 j2"), springs=springs, gravity=PLANE, **options)


def four_bar_text(p, kind="revolute", *more: str) -> str:
    crank, coupler, rocker = p["lengths"]
    return urdf(
        GROUND,
        bar("crank", p["masses"][0], crank),
        bar("coupler", p["masses"][1], coupler),
        bar("rocker", p["masses"][2], rocker),
        joint("j1", "frame", "crank", kind),
        joint("j2", "crank", "coupler", kind, at=(crank, 0, 0)),
        joint("j3", "frame", "rocker", kind, at=(p["base"], 0, 0)),
        *more,
    )


def four_bar_loop(p, **options):
    return mb.Loop("coupler", (p["lengths"][1], 0, 0), "rocker", (p["lengths"][2], 0, 0), name="closure", **options)


def four_bar(p, kind="revolute", loops=None, **options):
    options.setdefault("gravity", PLANE)
    options |= {"joint_stiffness": {"j1": p["stiffness"]}, "joint_rest": {"j1": p["rest"]}}
    if "damping" in p:
        options["joint_damping"] = dict(zip(("j1", "j2", "j3"), p["damping"]))
    loops = [four_bar_loop(p)] if loops is None else loops
    return linkage(four_bar_text(p, kind), start(p, "j1 j2 j3"), loops=loops, **options)


def four_bar_with_pin(p, turned=0.0):
    """The pin hangs at the tip of the coupler by a real joint j4 and is fastened to the rocker."""
    pin = link("pin", p["pin_mass"], (p["pin_offset"], 0, 0), (1e-3, 1e-3, p["pin_inertia"]))
    j4 = joint("j4", "coupler", "pin", at=(p["lengths"][1], 0, 0))
    loop = mb.Loop(
        "pin",
        (0, 0, 0),
        "rocker",
        (p["lengths"][2], 0, 0),
        kind="rigid",
        rotation1=(0, 0, turned),
        rotation2=(0, 0, turned),
        name="closure",
    )
    j1, j2, j3 = p["guess"]
    return linkage(
        four_bar_text(p, "revolute", pin, j4),
        {"j1": j1, "j2": j2, "j3": j3, "j4": j3 - j1 - j2},
        loops=[loop],
        gravity=PLANE,
        **spring(p),
    )


def hanging_four_bar(p, kind="revolute", spin=1e-3):
    lengths, names = p["lengths"], ("first", "second", "third")
    bars = [bar(name, m, length, spin) if m else link(name) for name, m, length in zip(names, p["masses"], lengths)]
    parents, places = ("frame", *names[:2]), (0, *lengths[:2])
    joints = [joint(f"j{i + 1}", parents[i], names[i], kind, at=(places[i], 0, 0)) for i in range(3)]
    loop = mb.Loop("third", (lengths[2], 0, 0), "ground", (*p["end"], 0), name="hook")
    return linkage(urdf(GROUND, *bars, *joints), start(p, "j1 j2 j3"), loops=[loop], gravity=PLANE)


def free_parallelogram(crank_mass, mass, length, width, spin=1e-3):
    """Two cranks and a coupler that is a free planar body (slides x and y, turn), constrained by two loops."""
    cranks = [bar(name, crank_mass, length) if crank_mass else link(name) for name in ("left", "right")]
    model = urdf(
        GROUND,
        *cranks,
        link("across"),
        link("along"),
        link("coupler", mass, (width / 2, 0, 0), (spin, spin, mass * width**2 / 12)),
        joint("j1", "frame", "left", "continuous"),
        joint("j2", "frame", "right", "continuous", at=(width, 0, 0)),
        joint("x", "frame", "across", "prismatic", axis=(1, 0, 0)),
        joint("y", "across", "along", "prismatic", axis=(0, 1, 0)),
        joint("turn", "along", "coupler", "continuous"),
    )
    loops = [
        mb.Loop("left", (length, 0, 0), "coupler", (0, 0, 0), name="left pin"),
        mb.Loop("right", (length, 0, 0), "coupler", (width, 0, 0), name="right pin"),
    ]
    return linkage(model, {"j1": -1.5, "j2": -1.5, "x": 0.02, "y": -length}, loops=loops, gravity=PLANE)


def slider_crank(p, **options):
    crank, rod = p["lengths"]
    model = urdf(
        GROUND,
        bar("crank", p["masses"][0], crank),
        bar("rod", p["masses"][1], rod),
        link("slider", p["masses"][2], (0.05, 0.02, 0), (1e-3, 1e-3, 1e-3)),
        joint("j1", "frame", "crank", "continuous"),
        joint("j2", "crank", "rod", "continuous", at=(crank, 0, 0)),
        joint("slide", "frame", "slider", "prismatic", at=(0, p["height"], 0), axis=(1, 0, 0), damping=p["damping"]),
    )
    loop = mb.Loop("rod", (rod, 0, 0), "slider", (0, 0, 0), name="wrist")
    return linkage(model, start(p, "j1 j2 slide"), loops=[loop], gravity=PLANE, **spring(p, "slide"), **options)


def six_bar(p):
    crank, coupler, rocker, rod, arm = p["lengths"]
    names = ("crank", "coupler", "rocker", "rod", "arm")
    bars = [bar(name, m, length) for name, m, length in zip(names, p["masses"], p["lengths"])]
    joints = [
        joint("j1", "frame", "crank"),
        joint("j2", "crank", "coupler", at=(crank, 0, 0)),
        joint("j3", "frame", "rocker", at=(p["base"], 0, 0)),
        joint("j4", "coupler", "rod", at=(*p["coupler_point"], 0)),
        joint("j5", "frame", "arm", at=(*p["second_base"], 0)),
    ]
    loops = [
        mb.Loop("coupler", (coupler, 0, 0), "rocker", (rocker, 0, 0), name="first"),
        mb.Loop("rod", (rod, 0, 0), "arm", (arm, 0, 0), name="second"),
    ]
    springs = {f"joint_{key}": dict(zip(("j1", "j5"), p[key])) for key in ("stiffness", "rest")}
    return linkage(urdf(GROUND, *bars, *joints), start(p, "j1 j2 j3 j4 j5"), loops=loops, gravity=PLANE, **springs)


def strut(p):
    spring = mb.BodySpring(
        "lower",
        (p["along"], 0, 0),
        "ground",
        (*p["anchor"], 0),
        stiffness=p["spring"],
        rest_length=p["rest_length"],
        damping=p["damping"],
        name="strut",
    )
    return double_pendulum(p, springs=[spring])


def spatial_loop(p):
    crank, rod, rocker = p["lengths"]
    swing = p["masses"][2] * rocker**2 / 12
    model = urdf(
        GROUND,
        bar("crank", p["masses"][0], crank, p["spin"]),
        link("cross"),
        bar("rod", p["masses"][1], rod, p["spin"]),
        link("rocker", p["masses"][2], (0, rocker / 2, 0), (swing, p["spin"], swing)),
        joint("j1", "frame", "crank"),
        joint("u1", "crank", "cross", at=(crank, 0, 0), axis=(0, 1, 0)),
        joint("u2", "cross", "rod"),
        joint("j4", "frame", "rocker", at=p["base"], axis=(1, 0, 0)),
    )
    loop = mb.Loop("rod", (rod, 0, 0), "rocker", (0, rocker, 0), name="ball")
    return linkage(model, start(p, "j1 u1 u2 j4"), loops=[loop], **spring(p))


def spherical(p, half_turn=False):
    """All origins in the point where the axes meet; the last hinge is a loop whose frames have the axis as z."""
    arc1, arc2, arc3, arc4 = p["arcs"]
    names = ("first", "second", "third")
    links = [link(name, m, p["centre"], (i, i, i)) for name, m, i in zip(names, p["masses"], p["inertias"])]
    model = urdf(
        GROUND,
        *links,
        joint("j1", "frame", "first"),
        joint("j2", "first", "second", turned=(arc1, 0, 0)),
        joint("j3", "frame", "third", turned=(arc4, 0, 0)),
    )
    end = -arc3 if half_turn else arc3  # Rz(pi) Rx(-arc) = Rx(arc) Rz(pi)
    loop = mb.Loop(
        "second",
        (0, 0, 0),
        "third",
        (0, 0, 0),
        kind="hinge",
        rotation1=(arc2, 0, 0),
        rotation2=(end, 0, np.pi * half_turn),
        name="last",
    )
    return linkage(model, start(p, "j1 j2 j3"), loops=[loop], **spring(p))


def free_pendulum(p):
    model = urdf(
        link("hull", p["base_mass"], (0, 0, 0), p["base_inertia"]),
        bar("panel", p["mass"], p["length"], p["spin"]),
        joint("j1", "hull", "panel", at=p["hinge"], axis=(0, 1, 0)),
    )
    guess, springs = {"base": (0.3, -0.2, 1.0, 0.4, -0.7, 2.1), "j1": p["angle"]}, spring({**p, "rest": p["angle"]})
    return linkage(model, guess, base="free", gravity=(0, 0, 0), **springs)


def platform(p):
    springs = [
        mb.BodySpring(
            "body", s["on_body"], "ground", s["on_ground"], stiffness=s["stiffness"], rest_length=s["rest_length"], name=f"leg {i}"
        )
        for i, s in enumerate(p["springs"])
    ]
    return linkage(urdf(link("body", p["mass"], (0, 0, 0), p["inertia"])), {}, base="free", springs=springs)


def bushing(p):
    mount = mb.Bushing(
        "body",
        p["on_body"],
        "ground",
        p["on_body"],
        stiffness=(p["stiffness"],) * 3,
        turning_stiffness=p["turning_stiffness"],
        name="mount",
    )
    return linkage(urdf(link("body", p["mass"], (0, 0, 0), p["inertia"])), {}, base="free", springs=[mount])


def string(p):
    model = urdf(
        GROUND,
        link("along"),
        link("across"),
        link("bead", p["mass"]),
        joint("x", "frame", "along", "prismatic", axis=(1, 0, 0)),
        joint("y", "along", "across", "prismatic", axis=(0, 1, 0)),
        joint("z", "across", "bead", "prismatic"),
    )
    springs = [
        mb.BodySpring("bead", (0, 0, 0), "ground", (x, 0, 0), stiffness=p["stiffness"], rest_length=p["rest_length"], name=name)
        for name, x in (("left", -p["half_span"]), ("right", p["half_span"]))
    ]
    return linkage(model, start(p, "x y z"), springs=springs, gravity=p["gravity"])


def flexible_arm(p):
    columns = zip(
        p["flexibility"], p["flexible_damping"], p["motor_inertia"], p["gear_ratio"], p["proportional_gain"], p["derivative_gain"]
    )
    motors = {
        f"j{i + 1}": mb.FlexibleJoint(k, damping=c, motor_inertia=b, gear_ratio=n, proportional_gain=kp, derivative_gain=kd)
        for i, (k, c, b, n, kp, kd) in enumerate(columns)
    }
    return double_pendulum(p, flexible_joints=motors)


BUILDERS = {
    "double pendulum": double_pendulum,
    "four-bar": four_bar,
    "four-bar with dampers": four_bar,
    "four-bar with a pin": four_bar_with_pin,
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
    "taut string": string,
    "sagging string": string,
    "flexible arm": flexible_arm,
    "flexible arm with PD": flexible_arm,
}
CONSTRAINED = {"flexible arm": "all", "flexible arm with PD": "all"}


def linearized(name: str, **options):
    """(robot, posture, system) of a linkage of the table at its equilibrium."""
    robot, guess = BUILDERS[name](given(name), **options)
    posture = robot.equilibrium(guess, hold=CONSTRAINED.get(name, ()))
    return robot, posture, robot.linearize(posture)


def null_space(A: np.ndarray) -> np.ndarray:
    """An orthonormal basis of the motions that the rows A allow."""
    _, values, rows = np.linalg.svd(np.atleast_2d(A))
    return rows[int((values > 1e-9 * values.max(initial=1e-300)).sum()) :].T


def allowed(system) -> np.ndarray:
    """The motions that the loops of a robot allow."""
    return null_space(system.constraint_matrix) if len(system.constraint_matrix) else np.eye(system.size)
