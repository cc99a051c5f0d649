"""Methods of systems and motions that most do without; what answers them is imported when they are called."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, cast

from ..channels import NamedDirections

if TYPE_CHECKING:
    from ...frequency.random.random_response import RandomResponse
    from ..motion import Motion
    from ..system import MechanicalSystem
    from .peaks import ModalCombination, Peaks


class SystemQuestions(NamedDirections):
    """Random excitation and response spectra of a ``MechanicalSystem``."""

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
            of: "displacement", "velocity", "acceleration" or "reaction".
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
