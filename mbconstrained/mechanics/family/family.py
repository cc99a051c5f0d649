"""``family``: many mechanical systems of one structure, solved in stacks of matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...ground.checks import counted, real_array
from ...ground.errors import InputError
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import step, zero
from ..constraints import Constraint
from ..system import MechanicalSystem
from .family_frequency_response import FamilyFrequencyResponse, family_frequency_response
from .family_modes import FamilyModes, family_modes
from .family_motion import FamilyMotion
from .family_random_response import FamilyRandomResponse, family_random_response
from .system_stack import SystemStack


def family(
    mass,
    damping=None,
    stiffness=None,
    constraints: Sequence[Constraint] = (),
    names: Sequence[str] | None = None,
    force=None,
    static_force=None,
    units=None,
) -> Family:
    """Create S mechanical systems of one structure with different constants, such as the samples of a tolerance study.

    The structure (constraints, massless coordinates, which equation has which order) is decided once, for the first system. Modes,
    motions and frequency responses are computed in stacks of matrices; each has an error estimate, and systems that fall short of
    1e-12, or of the structure, are solved one by one (``MechanicalSystem``).

    Args:
        mass, damping, stiffness: as in ``MechanicalSystem``, of shape (n, n), common to all, or (S, n, n).
        constraints: common to all.
        names, force, units: as in ``MechanicalSystem``, common to all.
        static_force: a constant force, shape (n,) or (S, n).

    Returns:
        A ``Family``, a sequence of S systems.

    Raises:
        InputError: shapes that do not match, no matrix with a leading axis.

    >>> k = np.array([4.0, 9.0, 16.0])
    >>> oscillators = family([[1.0]], stiffness=k.reshape(-1, 1, 1))
    >>> oscillators.modes().natural_frequencies.round(12).tolist()
    [[2.0], [3.0], [4.0]]
    >>> oscillators.solve([1.0])([np.pi]).round(12).tolist()
    [[[1.0]], [[-1.0]], [[1.0]]]
    """
    given = {"mass": mass, "damping": damping, "stiffness": stiffness}
    arrays = {name: real_array(value, name) for name, value in given.items() if value is not None}
    if static_force is not None:
        arrays["static_force"] = real_array(static_force, "static_force")
    counts = {name: len(array) for name, array in arrays.items() if array.ndim == (2 if name == "static_force" else 3)}
    if not counts:
        raise InputError("family: found no matrix of shape (S, n, n); expected at least one, with a matrix for each of S systems")
    if len(set(counts.values())) > 1 or not min(counts.values()):
        sizes = ", ".join(f"{name} of {counted(count, 'system')}" for name, count in counts.items())
        raise InputError(f"family: found {sizes}; expected one number of systems, at least 1")
    first = {name: array[0] if name in counts else array for name, array in arrays.items()}
    M, C, K = (first.get(name) for name in given)
    base = MechanicalSystem(M, C, K, constraints, names, force, first.get("static_force"), units)
    count, shape = next(iter(counts.values())), (base.size, base.size)
    for name, array in arrays.items():
        expected = (base.size,) if name == "static_force" else shape
        if array.shape[name in counts :] != expected:
            raise InputError(f"{name}: expected shape {expected} or ({count}, ...), found {array.shape}")
    stacks = [np.broadcast_to(arrays.get(name, np.zeros(shape)), (count, *shape)) for name in given]
    own = arrays["static_force"] - arrays["static_force"][0] if "static_force" in counts else np.zeros((count, base.size))
    return Family(base, stacks[0], stacks[1], stacks[2], base.static_force + own)


class Family(SystemStack):
    """S systems; ``systems[3]`` is one ``MechanicalSystem``.

    Attributes:
        base: the first system, whose structure, names, constraints and force all have.
        mass, damping, stiffness: shape (S, n, n).
        static_force: shape (S, n).
    """

    def modes(self) -> FamilyModes:
        """The modes of all systems.

        Returns:
            ``FamilyModes``.

        Raises:
            SingularPolynomialMatrix: the motion of a system is not determined.
        """
        return family_modes(self)

    def solve(self, displacement=None, velocity=None, force=None) -> FamilyMotion:
        """The motions of all systems from values at 0-, under the same force.

        Args:
            displacement, velocity: x and x' at 0-, shape (n,) or by name, common to all; or (S, n).
            force: f in addition to that of the systems, as in ``MechanicalSystem.solve``.

        Returns:
            A ``FamilyMotion``, a function of time.
        """
        base, count = self.base, len(self)
        start = np.empty((count, 2, base.size))
        for place, (value, what) in enumerate(((displacement, "displacement"), (velocity, "velocity"))):
            if value is not None and not hasattr(value, "items") and np.ndim(value) == 2:
                start[:, place] = real_array(value, what, shape=(count, base.size))
            else:
                start[:, place] = base._vector(value, what)
        if force is None:
            added = zero(base.size)
        else:
            added = base._signal(force if isinstance(force, ImpulsiveSmooth) else step(base._vector(force, "force")))
        return FamilyMotion(self, start, added if base.excitation is None else base.excitation + added)

    def frequency_response(
        self, frequencies_hz, inputs=None, outputs=None, quantity: str = "receptance", relative_to: str | None = None
    ) -> FamilyFrequencyResponse:
        """The frequency responses of all systems from their poles and residues.

        Args:
            frequencies_hz: shape (F,).
            inputs, outputs, quantity, relative_to: as in ``MechanicalSystem.frequency_response``.

        Returns:
            A ``FamilyFrequencyResponse``.
        """
        return family_frequency_response(self, frequencies_hz, inputs, outputs, quantity, relative_to)

    def random_response(self, excitation: Mapping, outputs=None, quantity: str = "displacement", **options) -> FamilyRandomResponse:
        """The RMS values of all systems under the same random excitation.

        Args:
            excitation, outputs, quantity, options: as in ``MechanicalSystem.random_response``.

        Returns:
            A ``FamilyRandomResponse``.

        >>> import mbconstrained as mb
        >>> systems = mb.family([[1.0]], [[0.5]], [[[2.0]], [[8.0]]])
        >>> systems.random_response({"x1": mb.white_noise(4.0)}).rms.round(12).tolist()  # sqrt(G / (4 c k))
        [[1.0], [0.5]]
        """
        return family_random_response(self, excitation, outputs, quantity, options)
