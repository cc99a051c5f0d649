"""SRDF files: postures of a robot by name, and the rotors of its motors. Groups and collisions are not read."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path

from ...ground.checks import nearest
from ...ground.errors import InputError
from .urdf import numbers, parsed_xml, read_urdf, short

#: Numbers of a pose of the base: x, y, z and a quaternion x, y, z, w.
POSE = 7


@dataclass(frozen=True)
class SemanticDescription:
    """The content of an SRDF file.

    Attributes:
        states: values (rad, m) by joint, by name of the state; equal names of several groups are one state.
        rotors: inertia of the rotor (kg m^2, kg) and gear ratio by joint, of those that have both.
    """

    states: dict[str, dict[str, float | tuple[float, ...]]] = field(default_factory=dict)
    rotors: dict[str, tuple[float, float]] = field(default_factory=dict)

    def state(self, name: str, joints: Collection[str], base: str | None) -> dict[str, float | tuple[float, ...]]:
        """The values of the moving joints, as a guess.

        Args:
            name: name of the state.
            joints: the moving joints.
            base: the name of a free base, which takes the pose of a joint that is not among them; None of a fixed one.

        Returns:
            Values by joint.

        Raises:
            InputError: no such state.
        """
        if name not in self.states:
            there = f"; there are {', '.join(self.states)}" if self.states else ": no SRDF file with one is given (srdf)"
            raise InputError(f'state: there is no "{short(name)}"{nearest(name, self.states)}{there}')
        guess = {}
        for joint, value in self.states[name].items():
            if joint in joints:
                guess[joint] = value
            elif base is not None and isinstance(value, tuple) and len(value) == POSE:
                guess[base] = value
        return guess


def read_srdf(path: str | Path) -> SemanticDescription:
    """States and rotors of an SRDF file."""
    root = parsed_xml(read_urdf(path, "SRDF")[0], "srdf")
    content = SemanticDescription()
    for state in root.iter("group_state"):
        name = state.get("name", "")
        values = content.states.setdefault(name, {})
        for joint in state.findall("joint"):
            text, where = joint.get("value", ""), f'srdf, state "{short(name)}", joint "{short(joint.get("name"))}"'
            entries = numbers(text, max(1, len(text.split())), where)
            values[joint.get("name", "")] = entries[0] if len(entries) == 1 else tuple(entries)
    for joint in root.iterfind(".//rotor_params/joint"):
        where = f'srdf, rotor of "{short(joint.get("name"))}"'
        (inertia,), (ratio,) = (numbers(joint.get(key, "0"), 1, f"{where}, {key}") for key in ("mass", "gear_ratio"))
        if inertia < 0:
            raise InputError(f"{where}, mass: found {inertia:g}; expected at least 0")
        if inertia and ratio:
            content.rotors[joint.get("name", "")] = inertia, ratio
    return content
