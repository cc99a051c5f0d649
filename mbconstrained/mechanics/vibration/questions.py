"""Methods of systems and motions that most do without; what answers them is imported when they are called."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar, cast

import numpy as np

from ..channels import NamedDirections

if TYPE_CHECKING:
    from ...frequency.random.random_response import RandomResponse
    from ..motion import Motion
    from ..sensitivity.parameter import Parameter
    from ..sensitivity.sensitivities import Sensitivities
    from ..system import MechanicalSystem
    from .effective_masses import EffectiveMasses
    from .peaks import ModalCombination, Peaks
    from .root_locus import RootLocus
    from .rotating import Campbell
    from .rotor_equations import SpeedTable
    from .unbalance_response import UnbalanceResponse


class SystemQuestions(NamedDirections):
    """Random excitation, response spectra, rotation and sensitivities of a ``MechanicalSystem``.

    Attributes:
        base_class: ``MechanicalSystem``, for systems that are derived from others.
        speed_tables: bearings whose coefficients change with the speed.
        whirl_matrix: S of ``Campbell.whirl``, shape (n, n); None for that of the gyroscopic moments.
        unbalance: u of the force W^2 Re(u e^{i W t}) of the unbalance, complex, in kg m, shape (n,); None if there is none.
    """

    base_class: ClassVar[type[MechanicalSystem]]
    speed_tables: tuple[SpeedTable, ...] = ()
    whirl_matrix: np.ndarray | None = None
    unbalance: np.ndarray | None = None

    @property
    def turns(self) -> bool:
        """Whether something of it depends on a speed of rotation."""
        system = cast("MechanicalSystem", self)
        return bool(self.speed_tables) or any(one is not None for one in (system.gyroscopic, system.circulatory, self.unbalance))

    def at_speed(self, speed: float) -> MechanicalSystem:
        """The rotor at a constant speed W: the system with C + W G and K + W N, whose motion, modes and responses are those at this speed.

        Args:
            speed: W in rad/s.

        Returns:
            A system without ``gyroscopic`` and ``circulatory`` matrices.

        Raises:
            InputError: the system has neither.

        >>> from mbconstrained import MechanicalSystem
        >>> disc = MechanicalSystem(np.eye(2), stiffness=np.eye(2), gyroscopic=[[0.0, 1.5], [-1.5, 0.0]])
        >>> disc.at_speed(1.0).modes().natural_frequencies.round(12)  # 2 and 1/2: their product is k / m
        array([0.5, 2. ])
        """
        from .rotor_equations import at_speed

        return at_speed(cast("MechanicalSystem", self), speed)

    def campbell(self, speeds) -> Campbell:
        """The eigenvalues over the speed of rotation, each followed through crossings and veerings.

        Args:
            speeds: W in rad/s, ascending, two or more.

        Returns:
            A ``Campbell``: ``eigenvalues``, ``natural_frequencies``, ``damping_ratios``, ``whirl``, ``stability_margins``, ...

        >>> from mbconstrained import MechanicalSystem
        >>> disc = MechanicalSystem(np.eye(2), stiffness=np.eye(2), gyroscopic=[[0.0, 1.5], [-1.5, 0.0]])
        >>> diagram = disc.campbell([0.0, 1.0])
        >>> diagram.natural_frequencies.round(12).tolist(), diagram.directions
        ([[1.0, 1.0], [0.5, 2.0]], ('backward', 'forward'))
        """
        from .rotating import campbell

        return campbell(cast("MechanicalSystem", self), speeds)

    def critical_speeds(self, order: float = 1.0) -> np.ndarray:
        """The speeds W at which an eigenvalue has the imaginary part n W, where an excitation of this order is in resonance.

        With W = s / (i n) the equations at critical speeds are one polynomial eigenproblem, whatever the speed,

            [(M + G / (i n)) s^2 + (C + N / (i n)) s + K] x = 0.

        Without damping s = i n W are its imaginary eigenvalues: all critical speeds at once. With damping W is complex, and each
        is the start of Newton's method on Im s(W) = n W.

        Args:
            order: n: 1 for unbalance, 2 for a shaft of two stiffnesses, 1/2 for oil whirl.

        Returns:
            In rad/s, ascending; both directions of whirl, motions of free bodies left out.

        Raises:
            InputError: an order that is not positive.

        >>> from mbconstrained import MechanicalSystem
        >>> disc = MechanicalSystem(np.eye(2), stiffness=np.eye(2), gyroscopic=[[0.0, 0.75], [-0.75, 0.0]])
        >>> disc.critical_speeds().round(12)  # 1 / sqrt(1 +- 3/4)
        array([0.75592895, 2.        ])
        """
        from .rotating import critical_points

        return np.array([point.speed for point in critical_points(cast("MechanicalSystem", self), order)])

    def unbalance_response(self, speeds, unbalance=None, order: float = 1.0) -> UnbalanceResponse:
        """The steady states under unbalance over the speed, with their peaks.

            (K(W) + i n W C(W) - n^2 W^2 M) x = W^2 u

        Args:
            speeds: W in rad/s, ascending, two or more, at least 0.
            unbalance: u in kg m, complex, shape (n,) or by name; for an eccentric mass m e in y and -i m e in z. By default that of
                the model.
            order: n of the frequency n W of the force.

        Returns:
            An ``UnbalanceResponse``: ``values``, ``amplitudes``, ``peaks``.

        Raises:
            InputError: no unbalance, speeds that do not ascend, a speed beyond the table of a bearing.

        >>> from mbconstrained import LumpedModel
        >>> model = LumpedModel()
        >>> _ = model.rotor("disc", 2.0), model.bearing("ground", "disc", stiffness=200.0, damping=4.0)
        >>> _ = model.unbalance("disc", 0.02)
        >>> peak = model.assemble().unbalance_response([1.0, 20.0]).peaks[0]
        >>> round(peak.speed, 9), round(peak.amplitude, 9)  # zeta = 0.1: 10 / sqrt(1 - 2 zeta^2), e / (2 zeta sqrt(1 - zeta^2))
        (10.101525446, 0.050251891)
        """
        from .unbalance_response import unbalance_response

        return unbalance_response(cast("MechanicalSystem", self), speeds, unbalance, order)

    def root_locus(self, parameter, values) -> RootLocus:
        """The eigenvalues over a parameter, with the break points where two of them coalesce.

        M, C and K depend linearly on the masses, dampers and springs of a model and on the entries of the matrices. At a break
        point A(s; p) x = 0 and y^H A_s(s; p) x = 0; it is solved for by Newton's method, not found on a grid.

        Args:
            parameter: a name as of ``sensitivities``, or an ``mb.Parameter``.
            values: p, ascending, two or more.

        Returns:
            A ``RootLocus``: ``eigenvalues``, ``break_points``, ``stability_limits``, ``damping_ratios``.

        Raises:
            InputError: an unknown name, a parameter that constraint rows depend on, sparse matrices.

        >>> from mbconstrained import MechanicalSystem
        >>> oscillator = MechanicalSystem([[1.0]], [[1.0]], [[4.0]])
        >>> point = oscillator.root_locus("damping[x1, x1]", [0.0, 3.0, 6.0]).break_points[0]
        >>> round(point.parameter, 12), point.eigenvalue  # critical damping 2 sqrt(k m), s = -sqrt(k / m)
        (4.0, (-2+0j))
        """
        from .root_locus import root_locus

        return root_locus(cast("MechanicalSystem", self), parameter, values)

    def modal_combination(self, spectrum, base=None, damping_ratio: float = 0.05, combination: str = "CQC") -> ModalCombination:
        """Response spectrum analysis of a moving base: participation factors, effective masses, peaks by CQC or SRSS.

        Args:
            spectrum: a ``ShockResponseSpectrum``, a function of the frequency in Hz, or a table (f, S_a) in Hz and m/s^2.
            base: names of the constraint rows that move together by one unit; all rows by default.
            damping_ratio: of all modes.
            combination: "CQC" or "SRSS".

        Returns:
            A ``ModalCombination``.

        >>> from mbconstrained import Constraint, MechanicalSystem
        >>> K = [[100.0, -100.0], [-100.0, 100.0]]
        >>> tower = MechanicalSystem([[2.0, 0.0], [0.0, 0.0]], None, K, [Constraint([0, 1], names="base")])
        >>> tower.modal_combination(lambda f: 3.0).effective_masses.round(12)
        array([2.])
        """
        from .peaks import modal_combination

        return modal_combination(cast("MechanicalSystem", self), spectrum, base, damping_ratio, combination)

    def effective_masses(self, base=None) -> EffectiveMasses:
        """Effective masses and participation factors of the modes without damping under a moving base.

            Gamma_i = u_i^T M r with u_i^T M u_i = 1,    m_i = Gamma_i^2

        with the static response r to a unit motion of the base (Chopra, Dynamics of Structures, section 13.2).

        Args:
            base: names of constraint rows, each a direction of its own, all rows by default; or by a name of your own several rows
                that move together.

        Returns:
            ``EffectiveMasses``: ``masses``, shape (m, d), and ``totals`` of all modes, shape (d,).

        Raises:
            InputError: unknown rows, a system without rows.

        >>> from mbconstrained import Constraint, MechanicalSystem
        >>> K = [[100.0, -100.0], [-100.0, 100.0]]
        >>> tower = MechanicalSystem([[2.0, 0.0], [0.0, 0.0]], None, K, [Constraint([0, 1], names="base")])
        >>> tower.effective_masses().masses.round(12)
        array([[2.]])
        """
        from .effective_masses import effective_masses, loads_of_rows

        system = cast("MechanicalSystem", self)
        return effective_masses(system, *loads_of_rows(system, base))

    def parameters(self) -> tuple[Parameter, ...]:
        """The numbers of the system with the derivatives of its equations: of a lumped model by element, otherwise the entries of M, C, K."""
        from ..sensitivity.parameter import entry_parameters

        system = cast("MechanicalSystem", self)
        return tuple(entry_parameters(system) if system.parameter_source is None else system.parameter_source())

    def sensitivities(self, parameters=None) -> Sensitivities:
        """Derivatives of eigenvalues, shapes, motions and responses with respect to parameters, in closed form.

        Of a lumped model the parameters are its elements by name ("mount"), and their other numbers ("mount.rest_length"); of
        other systems the entries of M, C and K that are not zero ("stiffness[x1, x2]", of a symmetric matrix both of a pair).

        Args:
            parameters: names, or ``mb.Parameter`` objects with derivatives of their own; all by default.

        Returns:
            ``Sensitivities``: ``eigenvalues``, ``natural_frequencies``, ``logarithmic``, ``defective``, ``motion(name, ...)``, ...

        Raises:
            InputError: an unknown name, sparse matrices, modal damping.

        >>> from mbconstrained import MechanicalSystem
        >>> d = MechanicalSystem([[1.0]], stiffness=[[4.0]]).sensitivities()
        >>> dict(zip(d.names, d.natural_frequencies[:, 0].round(12).tolist()))  # w = sqrt(k / m)
        {'stiffness[x1, x1]': 0.25, 'mass[x1, x1]': -1.0}
        """
        from ..sensitivity.sensitivities import sensitivities

        return sensitivities(cast("MechanicalSystem", self), parameters)

    def random_response(self, excitation: Mapping, outputs=None, quantity: str = "displacement", **options) -> RandomResponse:
        """The stationary response to random forces and motions of supports, in closed form.

        Args:
            excitation: spectra (``mb.psd``, ``mb.white_noise``, ...) by the names of coordinates or constraint rows.
            outputs: names; all coordinates by default.
            quantity: "displacement", "velocity", "acceleration" or "reaction".
            options: ``relative_to``, ``modal_damping``, ``loss_factor``, ``coherence``, ``delays``, as of
                ``mechanics.vibration.random_excitation.random_response``.

        Returns:
            A ``RandomResponse``.

        >>> from mbconstrained import MechanicalSystem, white_noise
        >>> system = MechanicalSystem([[1.0]], [[0.5]], [[2.0]])
        >>> round(system.random_response({"x1": white_noise(4.0)}).covariance.item(), 12)  # G / (4 c k)
        1.0
        """
        from .random_excitation import random_response

        return random_response(cast("MechanicalSystem", self), excitation, outputs, quantity, **options)


class MotionQuestions:
    """Peaks of a ``Motion``."""

    def peaks(self, end: float, of: str = "displacement", combinations=None, names=None) -> Peaks:
        """Exact extrema on [0, end] with their times.

        Args:
            end: in s.
            of: "displacement", "velocity", "acceleration", "reaction", or "elongation" or "force" of springs and dampers by name.
            combinations: a matrix (p, r) of what is combined, such as the elongation of a spring.
            names: of the combinations.

        Returns:
            ``Peaks``: ``maximum``, ``minimum``, ``largest``, and a table with the times.

        >>> from mbconstrained import MechanicalSystem
        >>> MechanicalSystem([[1.0]], None, [[4.0]]).solve(velocity=[3.0]).peaks(1.0).maximum.round(12)
        array([1.5])
        """
        from .peaks import peaks

        return peaks(cast("Motion", self), end, of, combinations, names)
