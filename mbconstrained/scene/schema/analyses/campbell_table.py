"""The table [campbell]: the speeds and orders of a rotor's Campbell diagram and of its run-up."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from ....ground.errors import InputError
from ..entry_types import AngularVelocity, Number, Table


class CampbellTable(Table):
    """Eigenvalues and unbalance response over the speed of a rotor."""

    lowest: AngularVelocity | None = Field(None, alias="from", ge=0, description="The lowest speed; 0 by default.")
    highest: AngularVelocity | None = Field(
        None, alias="to", gt=0, description="The highest speed; by default beyond all critical speeds of order 1."
    )
    points: int = Field(101, ge=2, le=10_001, description="Number of speeds, both ends included.")
    orders: Annotated[list[Annotated[Number, Field(gt=0)]], Field(min_length=1, max_length=12)] = Field(
        [1.0], description="Orders of excitation, multiples of the speed: 1 for unbalance, 2 for a shaft of two stiffnesses."
    )

    @model_validator(mode="after")
    def _ascending(self):
        if self.lowest is not None and self.highest is not None and self.lowest >= self.highest:
            raise InputError(f"from is {self.lowest:g} rad/s and to {self.highest:g} rad/s; expected a range that ascends")
        if len(set(self.orders)) < len(self.orders):
            raise InputError("orders: one is given twice; give each once")
        return self
