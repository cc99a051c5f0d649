"""Random MJCF models over all constructs that are read, and MuJoCo's own M, K, C and loops at a posture as the oracle."""

import json
from pathlib import Path

import numpy as np

from mbconstrained.robot.description.mjcf import quiet


def text(*values) -> str:
    return " ".join(f"{value:.6g}" for value in values)


class Generator:
    """One model from a seed: bodies with several joints, frames, replicates, classes, springs, tendons, actuators and equalities."""

    def __init__(self, seed: int):
        self.rng = np.random.default_rng(seed)
        self.hinges: list[str] = []
        self.sites: list[tuple[str, str]] = []  # with the body
        self.bodies: list[str] = []
        self.degrees = self.rng.random() < 0.5
        self.loops = self.rng.random() < 0.4
        self.unit = 180 / np.pi if self.degrees else 1.0

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def vector(self, size: float = 0.3, count: int = 3) -> str:
        return text(*self.rng.uniform(-size, size, count))

    def turn(self) -> str:
        """An orientation in one of the five forms."""
        a, b = self.rng.normal(size=(2, 3))
        return str(
            self.rng.choice(
                [
                    "",
                    f'quat="{text(*self.rng.normal(size=4))}"',
                    f'euler="{text(*self.rng.uniform(-1, 1, 3) * self.unit)}"',
                    f'axisangle="{text(*a, self.rng.uniform(-2, 2) * self.unit)}"',
                    f'xyaxes="{text(*a, *b)}"',
                    f'zaxis="{text(*a)}"',
                ]
            )
        )

    def inertia(self) -> str:
        """An <inertial>, or geoms that carry the mass."""
        rng = self.rng
        if self.chance(0.4):
            a, b, c = rng.uniform(0.005, 0.05, 3)
            mass = f'mass="{rng.uniform(0.2, 3):.4g}" pos="{self.vector(0.2)}"'
            if self.chance(0.5):
                return f'<inertial {mass} {self.turn()} diaginertia="{text(a + b, b + c, a + c)}"/>'
            return f'<inertial {mass} fullinertia="{text(a + b, b + c, a + c, *rng.uniform(-0.002, 0.002, 3))}"/>'
        geoms = []
        for _ in range(rng.integers(1, 4)):
            kind = rng.choice(["box", "sphere", "capsule", "cylinder", "ellipsoid", "mesh", "class"])
            weight = rng.choice(["", f'mass="{rng.uniform(0.1, 2):.4g}"', f'density="{rng.uniform(100, 3000):.4g}"'])
            place = f'pos="{self.vector(0.2)}" {self.turn()}'
            off = str(rng.choice(["", 'contype="0" conaffinity="0"', 'group="3"']))
            size = text(*rng.uniform(0.03, 0.12, 3))
            if kind == "mesh":
                geoms.append(f'<geom type="mesh" mesh="{rng.choice(["block", "wedge"])}" {place} {weight} {off}/>')
            elif kind == "class":
                geoms.append(f'<geom class="heavy" {place}/>')
            elif kind == "capsule" and self.chance(0.5):
                geoms.append(f'<geom type="capsule" size="0.03" fromto="{self.vector(0.3, 6)}" {weight} {off}/>')
            else:
                geoms.append(f'<geom type="{kind}" size="{size}" {place} {weight} {off}/>')
        return "".join(geoms)

    def joint(self, name: str, ball: bool) -> str:
        rng = self.rng
        kind = "ball" if ball else str(rng.choice(["hinge", "hinge", "hinge", "slide"]))
        unit = self.unit if kind != "slide" else 1.0
        parts = [f'type="{kind}"', f'pos="{self.vector(0.1)}"' * self.chance(0.6)]
        if name:
            parts.append(f'name="{name}"')
        if not ball:
            parts.append(f'axis="{text(*rng.normal(size=3))}"')
            if name:
                self.hinges.append(name)
            if self.chance(0.3):
                parts.append(f'ref="{rng.uniform(-0.5, 0.5) * unit:.5g}"')
            if self.chance(0.3):
                parts.append(f'springref="{rng.uniform(-0.5, 0.5) * unit:.5g}"')
            if self.chance(0.2):
                parts.append(f'range="{text(-2 * unit, 2 * unit)}"')
        if self.chance(0.5):
            more = text(*rng.uniform(-20, 20, 2)) if self.chance(0.2) and not ball else ""
            parts.append(f'stiffness="{rng.uniform(5, 80):.5g} {more}"')
        elif self.chance(0.15) and not ball:
            parts.append('springdamper="0.1 0.6"')
        if self.chance(0.4) and not any("springdamper" in part for part in parts):
            parts.append(f'damping="{rng.uniform(0.1, 3):.5g} {"0.2 0.1" * self.chance(0.3)}"')
        if self.chance(0.3):
            parts.append(f'armature="{rng.uniform(0.01, 0.2):.4g}"')
        if self.chance(0.2):
            parts.append('class="soft"')
        return f"<joint {' '.join(filter(None, parts))}/>"

    def body(self, depth: int, parent: str = "world") -> str:
        rng, number = self.rng, len(self.bodies)
        name = f"b{number}"
        self.bodies.append(name)
        content = ""
        if depth == 0 and self.chance(0.15):
            content += (
                f'<freejoint name="f{number}"/>'
                if self.chance(0.5)
                else f'<joint name="f{number}" type="free" stiffness="30" damping="2" armature="0.1"/>'
            )
        elif self.chance(0.15):
            content += self.joint(f"j{number}_ball", True)
        else:
            for k in range(int(rng.choice([0, 1, 1, 1, 2, 3]))):
                content += self.joint(f"j{number}_{k}" if self.chance(0.9) else "", False)
            if "<joint" in content and self.chance(0.1):
                content += self.joint(f"j{number}_ball", True)
        content += self.inertia()
        content += f'<site name="s{number}" pos="{self.vector(0.2)}" {self.turn()}/>'
        self.sites.append((f"s{number}", name))
        if depth < 3:
            for _ in range(int(rng.choice([0, 1, 1, 2])) if depth else 1):
                if len(self.bodies) < 7:
                    child = self.body(depth + 1, name)
                    if self.chance(0.2):
                        child = f'<frame pos="{self.vector()}" {self.turn()} childclass="soft">{child}</frame>'
                    content += child
        lift = f'gravcomp="{rng.uniform(0.2, 1):.3g}"' if self.chance(0.2) else ""
        own = 'childclass="soft"' if self.chance(0.15) else ""
        return f'<body name="{name}" pos="{self.vector()}" {self.turn()} {lift} {own}>{content}</body>'

    def tendons(self) -> str:
        rng, parts = self.rng, []
        for number in range(int(rng.integers(0, 3))):
            spring = f'stiffness="{rng.uniform(5, 60):.4g} {"3 2" * self.chance(0.2)}" damping="{rng.uniform(0, 2):.4g}"'
            if self.chance(0.3):
                low = rng.uniform(0.0, 0.3)
                spring += f' springlength="{text(low, low + rng.choice([0.0, 0.1]))}"'
            if self.chance(0.2):
                spring += ' armature="0.05"'
            if self.chance(0.5) and len(self.hinges) >= 2:
                names = rng.choice(self.hinges, size=min(len(self.hinges), int(rng.integers(1, 4))), replace=False)
                joints = "".join(f'<joint joint="{name}" coef="{rng.uniform(-2, 2):.4g}"/>' for name in names)
                parts.append(f'<fixed name="t{number}" {spring}>{joints}</fixed>')
            elif len(self.sites) >= 3:
                names = [self.sites[i][0] for i in rng.permutation(len(self.sites))]
                path = [f'<site site="{name}"/>' for name in names[: int(rng.integers(2, 4))]]
                if self.chance(0.3) and len(names) >= 4:
                    path += ['<pulley divisor="2"/>', *(f'<site site="{name}"/>' for name in names[-2:])]
                parts.append(f'<spatial name="t{number}" {spring}>{"".join(path)}</spatial>')
        self.tendon_names = [part.split('name="')[1].split('"')[0] for part in parts]
        return f"<tendon>{''.join(parts)}</tendon>" * bool(parts)

    def actuators(self) -> str:
        rng, parts = self.rng, []
        for name in self.hinges:
            if self.chance(0.2):
                kind = rng.choice(["position", "velocity", "motor", "general", "intvelocity", "damper", "cylinder"])
                gear = f'gear="{rng.uniform(0.5, 3):.4g}"' * self.chance(0.5)
                own = {
                    "position": 'kp="20" kv="2" forcerange="-5 5" forcelimited="true"',
                    "velocity": 'kv="3"',
                    "motor": "",
                    "general": 'biastype="affine" gainprm="10" biasprm="1 -10 -1"',
                    "intvelocity": 'kp="15" actrange="-1 1"',
                    "damper": 'kv="2" ctrlrange="0 1"',
                    "cylinder": 'area="0.1" bias="0.1 -5 -1"',
                }[str(kind)]
                parts.append(f'<{kind} joint="{name}" {gear} {own}/>')
        for name in self.tendon_names:
            if self.chance(0.3):
                parts.append(f'<position tendon="{name}" kp="12" kv="1" gear="1.5"/>')
        return f"<actuator>{''.join(parts)}</actuator>" * bool(parts)

    def equalities(self) -> str:
        rng, parts = self.rng, []
        if self.loops and len(self.bodies) > 2:
            a, b = rng.choice(self.bodies, 2, replace=False)
            kind = rng.choice(["connect", "weld", "site", "weld site", "world"])
            active = 'active="false"' if self.chance(0.15) else ""
            if kind == "connect":
                parts.append(f'<connect body1="{a}" body2="{b}" anchor="{self.vector(0.2)}" {active}/>')
            elif kind == "weld":
                parts.append(f'<weld body1="{a}" body2="{b}" anchor="{self.vector(0.2)}" {active}/>')
            elif kind == "world":
                parts.append(f'<connect body1="{a}" anchor="{self.vector(0.2)}" {active}/>')
        if len(self.hinges) >= 2 and self.chance(0.4):
            a, b = rng.choice(self.hinges, 2, replace=False)
            parts.append(f'<joint joint1="{a}" joint2="{b}" polycoef="0 {rng.uniform(-2, 2):.4g} 0 0 0"/>')
        return f"<equality>{''.join(parts)}</equality>" * bool(parts)

    def model(self) -> str:
        rng = self.rng
        world = "".join(self.body(0) for _ in range(int(rng.choice([1, 1, 2, 3]))))
        if self.chance(0.15):
            world += (
                '<replicate count="3" euler="0 0 30"><body name="extra" pos="0.2 0 0"><joint name="c" axis="0 1 0" stiffness="7"/>'
                '<inertial mass="1" pos="0 0 -0.1" diaginertia="0.01 0.02 0.03"/></body></replicate>'
            )
        if not any(tag in world for tag in ("<joint", "<freejoint")):
            world += '<body name="last"><joint name="last" axis="0 1 0"/><geom size="0.1" pos="0 0 -0.3"/></body>'
        sequence = rng.choice(["", 'eulerseq="XYZ"', 'eulerseq="zyx"', 'eulerseq="ZxY"'])
        others = rng.choice(
            ["", 'inertiafromgeom="true"', 'settotalmass="7"', 'balanceinertia="true"', 'autolimits="false"'],
            p=[0.6, 0.1, 0.1, 0.1, 0.1],
        )
        if "false" in others and "range=" in world:
            others = ""
        compiler = f'<compiler angle="{"degree" if self.degrees else "radian"}" {sequence} {others}/>'
        flag = str(
            rng.choice(
                ["", 'spring="disable"', 'damper="disable"', 'gravity="disable"', 'actuation="disable"'],
                p=[0.8, 0.05, 0.05, 0.05, 0.05],
            )
        )
        option = f'<option gravity="{text(*rng.normal(size=3) * 5)}"><flag {flag}/></option>'
        classes = (
            '<default><geom density="700"/><default class="soft"><joint stiffness="11" damping="0.3"/></default>'
            '<default class="heavy"><geom type="box" size="0.05 0.06 0.07" density="2500"/></default></default>'
        )
        mesh = (
            '<asset><mesh name="block" scale="0.1 0.2 0.1" vertex="0 0 0 1 0 0 0 1 0 0 0 1 1 1 0 1 0 1 0 1 1 1 1 1"/>'
            '<mesh name="wedge" scale="0.2 0.2 0.2" refpos="0.1 0 0" refquat="1 0.2 0 0" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'
        )
        return f"<mujoco>{compiler}{option}{classes}{mesh}<worldbody>{world}</worldbody>{self.tendons()}{self.actuators()}{self.equalities()}</mujoco>"


def compiled_here(texts: str, _times=()):
    """The model without a process of its own, which other tests start."""
    import mujoco

    files = {name: content.encode() for name, content in json.loads(texts).items()}
    with quiet():
        return mujoco.MjModel.from_xml_string(
            files["main.xml"].decode(), {name: own for name, own in files.items() if name != "main.xml"}
        )


class Oracle:
    """MuJoCo by itself: M, the forces and their derivatives, and the rows of equalities, in its own coordinates."""

    def __init__(self, path: Path):
        import mujoco

        self.mujoco = mujoco
        with quiet():
            self.model = mujoco.MjModel.from_xml_path(str(path))
        off = mujoco.mjtDisableBit
        self.model.opt.disableflags |= int(off.mjDSBL_CONTACT | off.mjDSBL_LIMIT | off.mjDSBL_FRICTIONLOSS)
        self.model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        self.model.actuator_forcelimited[:] = False
        self.data = mujoco.MjData(self.model)

    def at(self, qpos, qvel=None):
        self.data.qpos[:], self.data.qvel[:] = qpos, 0.0 if qvel is None else qvel
        self.mujoco.mj_forward(self.model, self.data)
        return self.data

    def mass(self, qpos) -> np.ndarray:
        data, M = self.at(qpos), np.zeros((self.model.nv, self.model.nv))
        for column, unit in zip(M, np.eye(self.model.nv)):
            self.mujoco.mj_mulM(self.model, data, column, unit)
        return M

    def without_forces_at(self, qpos) -> None:
        """Constant controls with which actuators have no force at a posture."""
        force = self.at(qpos).actuator_force.copy()
        self.model.actuator_biasprm[:, 0] -= force

    def force(self, qpos, qvel=None) -> np.ndarray:
        data = self.at(qpos, qvel)
        return data.qfrc_bias - data.qfrc_passive - data.qfrc_actuator

    def moved(self, qpos, step) -> np.ndarray:
        moved = np.array(qpos)
        self.mujoco.mj_integratePos(self.model, moved, step, 1.0)
        return moved

    def derivative(self, force, h: float) -> np.ndarray:
        columns = [(8 * (force(u) - force(-u)) - (force(2 * u) - force(-2 * u))) / (12 * h) for u in np.eye(self.model.nv) * h]
        return np.array(columns).T

    def damping(self, qpos) -> np.ndarray:
        coarse, fine = (self.derivative(lambda v: self.force(qpos, v), h) for h in (2e-5, 1e-5))
        return 2 * fine - coarse

    def rows(self, qpos) -> np.ndarray:
        data = self.at(qpos)
        return data.efc_J.reshape(-1, self.model.nv)[: data.ne].copy()
