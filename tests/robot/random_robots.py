"""Random robots from a seed: trees of hinges, slides and continuous joints, loops closed where they happen to lie."""

from dataclasses import dataclass

import numpy as np

import mbconstrained as mb
from tests.robot.linkages import joint, link, urdf
from tests.robot.reference import Reference


@dataclass
class Case:
    """A robot, the same for the referee, and the posture to start from."""

    robot: object
    reference: Reference
    guess: dict
    hold: object = ()


def random_link(rng, name: str) -> str:
    """Principal moments that obey the triangle inequality, in axes that are turned."""
    a, b, c = rng.uniform(0.01, 0.1, 3)
    return link(name, rng.uniform(0.3, 2), rng.uniform(-0.2, 0.2, 3), (a + b, b + c, a + c), rng.uniform(-1, 1, 3))


def random_tree(rng, joints: int, planar: bool) -> tuple[str, list[str], list[str]]:
    """(URDF, names of links, names of joints)."""
    names = ["root"] + [f"body {i}" for i in range(joints)]
    parts = [random_link(rng, name) for name in names]
    for i in range(joints):
        kind = rng.choice(["revolute", "continuous", "prismatic"], p=[0.5, 0.25, 0.25])
        axis = (0, 0, 1) if planar else rng.normal(size=3)
        at, turned = rng.uniform(-0.5, 0.5, 3), rng.uniform(-1, 1, 3)
        if planar:
            at[2], turned[:2] = 0, 0
            axis = (*rng.normal(size=2), 0) if kind == "prismatic" else axis
        parent = names[i] if rng.random() < 0.7 else names[rng.integers(0, i + 1)]
        parts.append(joint(f"j{i}", parent, names[i + 1], kind, at=at, turned=turned, axis=axis, damping=rng.choice([0.0, 0.3])))
    return urdf(*parts), names, [f"j{i}" for i in range(joints)]


def random_loops(rng, kinds, names, planar: bool, ground: bool) -> list:
    """Closures where the points happen to lie: between two links, or a link and the ground."""
    loops = []
    for i, kind in enumerate(kinds):
        first = names[-1 - i]
        second = "ground" if ground or rng.random() < 0.3 else names[rng.integers(0, len(names) - 1 - i)]
        options = {}
        if kind in ("hinge", "prismatic", "cylindrical"):
            options["axis"] = (0, 0, 1) if planar else rng.normal(size=3)
        point, turned = rng.uniform(-0.3, 0.3, 3), rng.uniform(-1, 1, 3) * ([0, 0, 1] if planar else 1)
        end = rng.uniform(-1, 1, 3) if kind == "rod" else None
        loops.append(mb.Loop(first, point, second, end, kind=kind, rotation1=turned, name=f"loop {i}", **options))
    return loops


def random_springs(rng, names, count: int) -> list:
    springs: list = []
    for i in range(count):
        first = names[rng.integers(1, len(names))]
        second = rng.choice(
            ["ground", *(name for name in names if name != first)], p=[0.4, *[0.6 / (len(names) - 1)] * (len(names) - 1)]
        )
        point1, point2 = rng.uniform(-0.3, 0.3, 3), rng.uniform(-1, 1, 3)
        force = [{"rest_length": rng.uniform(0.2, 1)}, {"preload": rng.uniform(-30, 30)}, {}][i % 3]
        springs.append(
            mb.BodySpring(
                first,
                point1,
                second,
                point2,
                stiffness=rng.uniform(50, 500),
                damping=rng.uniform(0, 5),
                name=f"spring {i}",
                **force,
            )
        )
    first, point = names[-1], rng.uniform(-0.3, 0.3, 3)
    values = {key: tuple(rng.uniform(200, 900, 3)) for key in ("stiffness", "turning_stiffness")}
    values |= {key: tuple(rng.uniform(0, 4, 3)) for key in ("damping", "turning_damping")}
    second = "ground" if rng.random() < 0.6 else names[1]
    return [*springs, mb.Bushing(first, point, second, name="bushing", rotation1=rng.uniform(-1, 1, 3), **values)]


def random_case(seed: int, kinds=(), joints: int = 5, planar=False, base="fixed", springs: int = 0, fixed=True) -> Case:
    """Fixed: motors keep the guess; else joint springs at rest near it, which the weight moves."""
    rng = np.random.default_rng([seed, joints, planar, springs, len(kinds)])
    text, names, moving = random_tree(rng, joints, planar)
    guess: dict = {name: float(rng.uniform(-1, 1)) for name in moving}
    gravity = (1.5, -9.0, 0.0) if planar else tuple(rng.normal(size=3) * 5)
    options = {
        "base": base,
        "gravity": gravity,
        "joint_stiffness": {name: float(rng.uniform(60, 150)) for name in moving},
        "joint_rest": dict(guess),
        "joint_damping": {name: float(rng.uniform(0, 2)) for name in moving[::2]},
        "loops": tuple(random_loops(rng, kinds, names, planar, ground=base == "free")),
        "springs": tuple(random_springs(rng, names, springs)) if springs else (),
    }
    robot, reference = mb.Robot(text, **options), Reference(text, **options)
    start = dict(guess)
    if base == "free":
        quaternion = rng.normal(size=4)
        start["base"] = (*rng.uniform(-1, 1, 3), *(quaternion / np.linalg.norm(quaternion)))
    reference.start = reference.configuration(guess, start.get("base"))
    return Case(robot, reference, start, "all" if fixed else ())
