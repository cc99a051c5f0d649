"""What scenes of kinds "transfer-function" and "state-space" are about: the model with its input and its outputs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..errors import IllConditioned
from ..models.transfer import Transfer, rational_transfer
from ..polynomial import PolynomialMatrix
from ..response import Response
from ..response.transfer import transfer_function_response
from ..response.transfer.engine import scalar_force, scalar_matrix
from ..response.transfer.rational import RationalFunction, rational_function
from ..signals import ImpulsiveSmooth
from .values import Coordinates

if TYPE_CHECKING:
    from ..mechanics.normal_form import NormalForm
    from ..models.state_space import StateSpace
    from ..models.state_space_response import StateSpaceResponse


#: Zeros are looked for in systems of so many states, and so many pairs of inputs and outputs, at most.
MOST_STATES, MOST_PAIRS = 40, 16


@dataclass(frozen=True)
class TransferFunction:
    """A transfer function with its input.

    Attributes:
        numerator, denominator: b and a as given, the highest power first.
        input: gamma of I_gamma, or u with one row.
        start: y^(i)(0-) as row i, shape (n, 1); None from rest.
    """

    numerator: list[float]
    denominator: list[float]
    input: int | ImpulsiveSmooth
    start: np.ndarray | None = None

    @cached_property
    def fraction(self) -> RationalFunction:
        """b(s)/a(s), exactly."""
        return rational_function(self.numerator, self.denominator)

    @property
    def acting(self) -> RationalFunction:
        """From rest without the common factor, which does not act then."""
        return self.fraction.reduced if self.start is None else self.fraction

    @property
    def polynomial_matrix(self) -> PolynomialMatrix:
        """a(s), size one."""
        return scalar_matrix(self.acting.denominator)

    @property
    def force(self) -> ImpulsiveSmooth:
        """b(d/dt) u."""
        return scalar_force(self.acting.numerator, self.input)

    def response(self) -> Response | None:
        """y from rest; None where it starts from other values, as any equations do."""
        if self.start is not None:
            return None
        return transfer_function_response(self.numerator, self.denominator, self.input)


@dataclass(frozen=True)
class ControlScene:
    """The model of a scene of control engineering, with its input.

    Attributes:
        inputs, outputs: names and units.
        transfer_function: b(s)/a(s) with its input, or else None.
        system: the state space, or else None.
        input: u, p rows, where it is a state space.
        start: x(0-), shape (n,), where it is a state space.
        form: its mechanical normal form, where that was asked for.
    """

    inputs: Coordinates
    outputs: Coordinates
    transfer_function: TransferFunction | None = None
    system: StateSpace | None = None
    input: ImpulsiveSmooth | None = None
    start: np.ndarray | None = None
    form: NormalForm | None = None

    @cached_property
    def response(self) -> StateSpaceResponse:
        """x and y of the state space; where it was made mechanical, this is where the outputs come from."""
        return self.system.solve(self.start, self.input)

    def output_values(self, times: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
        """The outputs at times (T,), shape (q, T), from those of the coordinates, of which they are the last."""
        if self.form is not None:
            return self.response.output(times)
        return coordinates[len(coordinates) - len(self.outputs.names) :]

    @cached_property
    def transfers(self) -> tuple[tuple[str, str, Transfer | None], ...]:
        """(input, output, G) of every pair; None where rounding hides the zeros of G, or they are not looked for."""
        if self.transfer_function is not None:
            return ((self.inputs.names[0], self.outputs.names[0], rational_transfer(self.transfer_function.fraction)),)
        return tuple((u, y, self._transfer(y, u)) for y in self.outputs.names for u in self.inputs.names)

    @property
    def looks_for_zeros(self) -> bool:
        """Whether the zeros of G are looked for, which takes long for many states or pairs."""
        pairs = len(self.inputs.names) * len(self.outputs.names)
        return self.system is None or (len(self.system.states) <= MOST_STATES and pairs <= MOST_PAIRS)

    @cached_property
    def dc_gains(self) -> np.ndarray | None:
        """G(0) of a state space, shape (q, p); None where it has a pole at 0."""
        return self.system.dc_gains()

    def _transfer(self, output: str, input: str) -> Transfer | None:
        if not self.looks_for_zeros:
            return None
        try:
            return self.system.transfer(output, input)
        except IllConditioned:
            return None
