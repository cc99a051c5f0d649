"""The factors of the matrices of a lumped model: K = B^T diag(k) B, C = B^T diag(c) B, M = diag(m)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..mechanics.element_matrix import ElementMatrix
from .elements import Body, Damper, Element, Spring, TorsionDamper, TorsionSpring


@dataclass(frozen=True)
class Branches:
    """The springs or the dampers of a model with n coordinates, one a row.

    Attributes:
        incidence: B, -1 at the start, 1 at the end, nothing for the ground, shape (p, n).
        constants: stiffness or damping, all positive, shape (p,).
        rest: elongation without force, shape (p,); zero for dampers.
        names: of the elements.
    """

    incidence: np.ndarray
    constants: np.ndarray
    rest: np.ndarray
    names: tuple[str, ...]

    @property
    def matrix(self) -> ElementMatrix:
        """B^T diag(constants) B, shape (n, n)."""
        return ElementMatrix(self.incidence, self.constants)

    def rest_force(self) -> np.ndarray:
        """B^T diag(constants) rest: what the rest lengths push with at x = 0, shape (n,)."""
        return self.incidence.T @ (self.constants * self.rest)


@dataclass(frozen=True)
class Incidence:
    """All factors of a model.

    Attributes:
        springs, dampers: the branches of K and of C.
        masses: masses and inertias by coordinate, zero for nodes, shape (n,).
    """

    springs: Branches
    dampers: Branches
    masses: np.ndarray


def incidence_of(elements: Sequence[Element]) -> Incidence:
    """The factors of the bodies, springs and dampers among these elements."""
    bodies = [element for element in elements if isinstance(element, Body)]
    names = [body.name for body in bodies]
    springs = [
        (element, element.stiffness, element.rest_length if isinstance(element, Spring) else element.rest_angle)
        for element in elements
        if isinstance(element, (Spring, TorsionSpring))
    ]
    dampers = [(element, element.damping, 0.0) for element in elements if isinstance(element, (Damper, TorsionDamper))]
    masses = [getattr(body, "mass", getattr(body, "inertia", 0.0)) for body in bodies]
    return Incidence(_branches(springs, names), _branches(dampers, names), np.array(masses))


def coordinate_row(coefficients: Mapping[str, float], names: Sequence[str]) -> np.ndarray:
    """Coefficients by name as a row, shape (n,); names that are no coordinate, as the ground, drop out."""
    return np.array([coefficients.get(name, 0.0) for name in names])


def _branches(found, names) -> Branches:
    rows = [coordinate_row({element.start: -1.0, element.end: 1.0}, names) for element, _, _ in found]
    return Branches(
        incidence=np.array(rows).reshape(len(found), len(names)),
        constants=np.array([constant for _, constant, _ in found]),
        rest=np.array([rest for _, _, rest in found]),
        names=tuple(element.name for element, _, _ in found),
    )
