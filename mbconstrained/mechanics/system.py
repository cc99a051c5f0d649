"""A mechanical system with the answers to all questions about it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from ..ground.by_name import answering
from ..ground.checks import is_table, whole_number
from ..ground.errors import InputError
from ..response.choose import Evaluations, Request
from ..signals.inputs import ImpulsiveSmooth
from .descriptor_form import discretize, system_to_dict, to_state_space
from .equations import EquationsOfMotion
from .modes import Modes, modes_of
from .motion import Motion, motion_of

if TYPE_CHECKING:
    from ..frequency.frequency_response import FrequencyResponse
    from ..frequency.random.random_response import RandomResponse
    from ..polynomial.characteristic_roots import CharacteristicRoots
    from .harmonic_response import SteadyState
    from .peaks import EffectiveMasses, ModalCombination
    from .root_locus import RootLocus
    from .rotating import Campbell, UnbalanceResponse
    from .sensitivities import Sensitivities

#: The number of modes of a system of sparse matrices that are computed where none is given.
DEFAULT_MODE_COUNT = 50

#: The number of rightmost modes of a system with delays that are computed where none is given.
DEFAULT_ROOT_COUNT = 10


@answering
class MechanicalSystem(EquationsOfMotion):
    """M x'' + C x' + K x = f + A^T lambda with the constraint rows A x^(level) = b, in SI units, for t in s.

    The matrices are all arrays, or some of them ``scipy.sparse``. Arrays have all their modes, and motions in closed form in all of
    them. Sparse matrices are kept sparse, whatever their size: they have their modes of lowest frequency, and the motion in these
    with a bound on the rest; M and K must be symmetric then, and rows are at position level.

    Args:
        mass: M, shape (n, n), possibly singular (kg, kg m^2). This one and the next two may be given as ``ElementMatrix``,
            which keeps the digits of elements that differ by many orders of magnitude.
        damping: C, shape (n, n) (N s/m); zero by default.
        stiffness: K, shape (n, n) (N/m); zero by default.
        constraints: ``Constraint`` objects, or sparse matrices of rows that are zero at position level. Dependent rows are left
            out and reported in ``notices``.
        names: names of the n coordinates; x1, x2, ... by default.
        force: f from t = 0 on: a constant vector (n,) or an ImpulsiveSmooth with n rows, in N or N m; or by name as in ``solve``.
        static_force: constant vector (n,) of rest lengths and weights, in addition to the force. Its potential counts in the
            energy, as that of a constant force does.
        units: units of each coordinate, "m" or "rad", by name or in order; "m" by default.
        energy_parts: M and K as sums of named parts, for the energy shares of modes; by coordinate by default. Arrays only.
        uncertainty: bounds of the errors of "mass", "damping", "stiffness", arrays (n, n) by these names, for matrices that are
            measured or computed; rounding errors by default. Arrays only.
        gyroscopic, circulatory: G and N of a rotor, shape (n, n): C + W G (kg m^2) and K + W N (N s/m) at W in rad/s; the system
            itself is the rotor at rest (``at_speed``, ``campbell``, ``critical_speeds``). Arrays only.
        delayed: forces with dead time, such as feedback: [K_j, C_j] by their delays in s adds K_j x(t - delay_j) + C_j x'(t - delay_j)
            to the left side. Arrays only.

    Raises:
        InputError: shapes that do not match, entries that are not finite, repeated names, an argument for arrays only.
        ContradictoryConstraints: dependent rows with different values.

    Attributes:
        is_sparse: whether one of the matrices is ``scipy.sparse``; all are compressed by columns (csc) then.
        pencil: the matrices on the free coordinates of a system of sparse matrices; None for arrays.
        given: K, C, M as they were given, each a matrix or its elements.
        static_force: the constant part of the force, shape (n,).
        excitation: the part of the force that varies in time; None if there is none.
        origin: the lumped model that it was assembled from, which has its drawing; None if there is none.

    >>> from mbconstrained import Constraint
    >>> pair = MechanicalSystem(np.diag([1.0, 3.0]), constraints=[Constraint([1, -1])], names=["a", "b"])
    >>> pair.acceleration([0, 0], [0, 0], [8.0, 0.0])
    array([2., 2.])

    A chain of 1000 unit masses between two walls, natural frequencies 2 sin(i pi / (2 (n + 1))):

    >>> import scipy.sparse
    >>> K = scipy.sparse.diags_array([-np.ones(999), 2 * np.ones(1000), -np.ones(999)], offsets=[-1, 0, 1])
    >>> modes = MechanicalSystem(scipy.sparse.eye_array(1000), stiffness=K).modes(count=10)
    >>> bool(np.allclose(modes.natural_frequencies, 2 * np.sin(np.arange(1, 11) * np.pi / 2002), rtol=1e-9)), modes.none_missed
    (True, True)
    """

    _instead: ClassVar = {
        "eig": "modes().eigenvalues",
        **dict.fromkeys(("bode", "frf", "transfer_function"), "frequency_response"),
        "eigenvalues": "modes().eigenvalues",
        "eigenvectors": "modes().shapes",
        "damping_ratios": "modes().damping_ratios",
        "frequencies_hz": "modes().frequencies_hz",
        "natural_frequencies": "modes().natural_frequencies",
        "plot": "solve(...).plot() draws a motion, frequency_response(...).plot() a frequency response",
        "run": "solve",
        "simulate": "solve",
        **dict.fromkeys(("t", "t_eval", "t_span", "time", "times"), "a motion is a function of time: solve(...)(times)"),
    }

    def solve(
        self,
        displacement=None,
        velocity=None,
        force=None,
        rank_tolerance: float | None = None,
        count: int | None = None,
        *,
        evaluations: Evaluations = "once",
        history=None,
    ) -> Motion | Any:
        """Solve for the motion from any values at 0-, in closed form.

        Inconsistent values are not repaired: the motion reports the jumps and impulses that they cause. Of sparse matrices

            x = sum of modes + X_f e^{J t} v + rest,

        where the second part follows the force and is exact, and the rest, free motion of the other modes, is bounded for all
        times by its energy at the start.

        Args:
            displacement, velocity: x and x' at 0-, shape (n,), or a mapping from names to numbers, zero for the others. Of
                shape (S, n): S motions at once; what is given only once is common to them.
            force: f in addition to the system's own, as an ImpulsiveSmooth with n rows, a constant vector, or a mapping from names to
                numbers and to functions of one row, such as {"cart": mb.step(5.0)}; or S of them.
            rank_tolerance: see ``mbconstrained.solve``. Arrays only.
            count: the number of modes of lowest frequency in the motion, 50 by default. Sparse matrices only.
            evaluations: see ``mbconstrained.solve``; the motion of sparse matrices is always evaluated by its modes.
            history: x before t = 0 for a system with delays, see ``mbconstrained.solve``; by default zero. It does not replace
                the values at 0-.

        Returns:
            A ``Motion``; ``Motions`` of S initial values or forces; a ``SparseMotion`` of sparse matrices.

        Raises:
            InputError: unknown names, shapes that do not match; of sparse matrices values at 0- that violate constraints,
                Dirac impulses, several motions.
            SingularPolynomialMatrix: the motion is not determined; the text names equations and coordinates.

        >>> spring = MechanicalSystem([[1.0]], stiffness=[[4.0]])
        >>> bool(np.isclose(spring.solve([1.0])(0.5)[0], np.cos(1.0)))
        True
        """
        self._refuse_loss_factors()
        request = Request(evaluations)
        several_forces = is_table(force) or (
            isinstance(force, (list, tuple)) and any(isinstance(f, (ImpulsiveSmooth, Mapping)) for f in force)
        )
        several = several_forces or is_table(displacement) or is_table(velocity)
        if several:
            self._refuse_delays("several motions at once")
        if self.is_sparse:
            from .sparse.sparse_motion import sparse_motion

            if several or rank_tolerance is not None:
                self._refuse_sparse("several motions" if several else "rank_tolerance")
            return sparse_motion(self, self._start(displacement, velocity), self._applied(force), _mode_count(count))
        if count is not None:
            raise InputError("count: the motion of a system given by arrays has all its modes; leave count out")
        if several:
            from .motions import motions_of

            forces = list(force) if several_forces else [force]
            applied = {id(one): self._applied(one) for one in forces}
            forces = [applied[id(one)] for one in forces]
            return motions_of(self, displacement, velocity, forces, rank_tolerance, request)
        return motion_of(self, self._start(displacement, velocity), self._applied(force), rank_tolerance, request, history)

    def modes(self, count: int | None = None, damped: bool = True) -> Modes:
        """Return the finite eigenvalues of A(s) with shapes and meaning: oscillation, decay, rigid body, drift, ...

        Of arrays all of them from the Jordan pairs of A(s). Of sparse matrices those of lowest frequency, by shift-invert Lanczos
        and Sylvester's law of inertia, which counts them; damped ones by Newton's method from these (``mechanics.sparse``).

        Args:
            count: the number of modes of lowest frequency; a complex pair counts once. By default all, of sparse matrices 50. With
                delays, which make infinitely many, that of the rightmost ones, 10 by default (``characteristic_roots``).
            damped: False for the modes without the damping C.

        Returns:
            The modes, ascending by modulus, after those of eigenvalue 0.

        Raises:
            InputError: a count below one; negative stiffness of a massless coordinate of sparse matrices.
            SingularPolynomialMatrix: the motion is not determined, coordinates have neither mass nor stiffness.

        >>> chain = MechanicalSystem(np.eye(2), 0.1 * np.eye(2), [[2.0, -1.0], [-1.0, 2.0]])
        >>> chain.modes().natural_frequencies.round(6), chain.modes(count=1).damping_ratios.round(6)
        (array([1.      , 1.732051]), array([0.05]))
        """
        if self.is_sparse:
            from .sparse.sparse_modes import sparse_modes

            return sparse_modes(self.pencil, _mode_count(count), damped and bool(self.damping.nnz))
        if self.delayed:
            if not damped:
                self._refuse_delays("modes without damping")
            from .modes import modes_with_delays

            return modes_with_delays(self, DEFAULT_ROOT_COUNT if count is None else count)
        modes = modes_of(self if damped else MechanicalSystem(self.given[2], None, self.given[0], self.constraints, self.names))
        return modes if count is None else modes.lowest(count)

    def characteristic_roots(self, count: int = 10) -> CharacteristicRoots:
        """The rightmost roots of the equations with delays, which decide on stability (``mbconstrained.characteristic_roots``).

        Args:
            count: how many, a complex pair counts once.

        Returns:
            ``CharacteristicRoots``: ``eigenvalues``, ``shapes``, ``stability_margin``, ``damping_ratios``.

        Raises:
            InputError: a system without delays; terms of neutral type.

        >>> from mbconstrained import MechanicalSystem
        >>> late = MechanicalSystem([[1.0]], [[0.2]], [[4.0]], delayed={0.1: [[[0.0]], [[1.0]]]})  # a delayed damper
        >>> round(float(late.characteristic_roots(1).damping_ratios[0]), 6)
        0.311141
        """
        from ..polynomial.characteristic_roots import rightmost_roots

        return rightmost_roots(self.undelayed_form().polynomial_matrix, self.delayed_equations(), count)

    def frequency_response(
        self,
        frequencies_hz="auto",
        inputs: Sequence[str] | str | None = None,
        outputs: Sequence[str] | str | None = None,
        quantity: str = "receptance",
        modal_damping=None,
        loss_factor=None,
        relative_to: str | None = None,
        count: int | None = None,
    ) -> FrequencyResponse:
        """The steady answer to harmonic loads: f e^{+i w t} gives H(i w) f e^{+i w t}, entry by entry with an error estimate.

        Args:
            frequencies_hz: shape (F,); "auto" for lines that the poles place.
            inputs, outputs: names of coordinates, of constraint rows, of outputs and elements; all coordinates by default.
            quantity: "receptance", "mobility", "accelerance", their inverses "dynamic stiffness", "impedance", "apparent mass",
                "transmissibility", "reaction" or "force".
            modal_damping: damping ratio of all modes, or of the lowest ones, in addition to the damping.
            loss_factor: eta of structural damping, K (1 + i eta); of elements by name as a mapping.
            relative_to: a coordinate or prescribed motion that is subtracted from the outputs.
            count: number of modes of sparse matrices, 50 by default.

        Returns:
            A ``FrequencyResponse``.

        Raises:
            InputError: an unknown name or quantity, frequencies that are not finite.

        >>> from mbconstrained import Constraint, MechanicalSystem
        >>> isolated = MechanicalSystem([[1.0, 0.0], [0.0, 0.0]], [[0.1, -0.1], [-0.1, 0.1]], [[4.0, -4.0], [-4.0, 4.0]],
        ...     [Constraint([0, 1], names="base")], names=["machine", "floor"])
        >>> T = isolated.frequency_response([np.sqrt(8) / (2 * np.pi)], ["base"], ["machine"], quantity="transmissibility")
        >>> bool(np.isclose(abs(T.values.item()), 1.0)), T.units.item()  # at sqrt(2) times the natural frequency
        (True, '1')
        """
        from .harmonic_response import frequency_response

        options = (quantity, modal_damping, loss_factor, relative_to, count)
        return frequency_response(self, frequencies_hz, inputs, outputs, *options)

    def steady_state(
        self,
        force: ImpulsiveSmooth | None = None,
        period: float | None = None,
        harmonics: int = 50,
        modal_damping=None,
        loss_factor=None,
        outputs: Sequence[str] | str = (),
        quantity: str = "displacement",
    ) -> SteadyState:
        """The motion under harmonic loads after all free motion has decayed: amplitude and phase of every coordinate and reaction.

        The static force of the system, its own excitation and the values of its constraint rows count too.

        Args:
            force: sum of harmonics, or a record of one period, in addition to the system's own; by rows or by name as in ``solve``.
            period: T in s of records, which repeat.
            harmonics: number of harmonics of a periodic record.
            modal_damping, loss_factor: as in ``frequency_response``.
            outputs: names of further outputs, such as springs and dampers for their forces.
            quantity: kind of outputs that are named alone, as of ``random_response``.

        Returns:
            A ``SteadyState``.

        Raises:
            InputError: sparse matrices, loads that do not repeat, an undamped motion in resonance.

        >>> import mbconstrained as mb
        >>> system = mb.MechanicalSystem([[1.0]], [[0.5]], [[4.0]])
        >>> steady = system.steady_state(mb.harmonic([3.0], angular_frequency=2.0))  # at resonance c w x = 3
        >>> abs(steady.displacement_amplitudes[0, 0]).round(9).item()
        3.0
        """
        from .harmonic_response import steady_state

        return steady_state(self, force, period, harmonics, modal_damping, loss_factor, outputs, quantity)

    to_state_space = to_state_space
    discretize = discretize
    to_dict = system_to_dict

    def at_speed(self, speed: float) -> Self:
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
        from .rotating import at_speed

        self._refuse_delays("a rotor")
        return at_speed(self, speed)

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
        from .rotating import campbell, check_rotor

        self._refuse_delays("campbell")
        check_rotor(self)
        return campbell(self, speeds)

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
        from .rotating import check_rotor, critical_points

        self._refuse_delays("critical_speeds")
        check_rotor(self)
        return np.array([point.speed for point in critical_points(self, order)])

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
        from .rotating import check_rotor, unbalance_response

        self._refuse_delays("unbalance_response")
        check_rotor(self)
        return unbalance_response(self, speeds, unbalance, order)

    def root_locus(self, parameter, values) -> RootLocus:
        """The eigenvalues over a parameter, with the break points where two of them coalesce.

        M, C and K depend linearly on the masses, dampers and springs of a model and on the entries of the matrices. At a break
        point A(s; p) x = 0 and y^H A_s(s; p) x = 0; it is solved for by Newton's method, not found on a grid.

        Args:
            parameter: a name as in ``sensitivities``, or an ``mb.Parameter``.
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

        self._refuse_delays("root_locus")
        return root_locus(self, parameter, values)

    def modal_combination(self, spectrum, base=None, damping_ratio: float = 0.05, combination: str = "CQC") -> ModalCombination:
        """Response spectrum analysis of a moving base: participation factors, effective masses, peaks by CQC or SRSS.

        Args:
            spectrum: a ``ShockResponseSpectrum``, a function of the frequency in Hz, or a table (f, S_a) in Hz and m/s^2.
            base: names of the constraint rows that move together by one unit; all rows by default.
            damping_ratio: damping ratio of all modes.
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

        self._refuse_delays("modal_combination")
        return modal_combination(self, spectrum, base, damping_ratio, combination)

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
        from .peaks import effective_masses, loads_of_rows

        self._refuse_delays("effective_masses")
        return effective_masses(self, *loads_of_rows(self, base))

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
        from .sensitivities import sensitivities

        self._refuse_delays("sensitivities")
        return sensitivities(self, parameters)

    def random_response(self, excitation: Mapping, outputs=None, quantity: str = "displacement", **options) -> RandomResponse:
        """The stationary response to random forces and motions of supports, in closed form.

        Args:
            excitation: spectra (``mb.psd``, ``mb.white_noise``, ...) by the names of coordinates or constraint rows.
            outputs: names; all coordinates by default.
            quantity: "displacement", "velocity", "acceleration" or "reaction".
            options: ``relative_to``, ``modal_damping``, ``loss_factor``, ``coherence``, ``delays``, as of
                ``mechanics.random_excitation.random_response``.

        Returns:
            A ``RandomResponse``.

        >>> from mbconstrained import MechanicalSystem, white_noise
        >>> system = MechanicalSystem([[1.0]], [[0.5]], [[2.0]])
        >>> round(system.random_response({"x1": white_noise(4.0)}).covariance.item(), 12)  # G / (4 c k)
        1.0
        """
        from .random_excitation import random_response

        return random_response(self, excitation, outputs, quantity, **options)


MechanicalSystem.base_class = MechanicalSystem


def _mode_count(count) -> int:
    return DEFAULT_MODE_COUNT if count is None else whole_number(count, "count", minimum=1)
