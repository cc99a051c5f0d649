"""The tables [boundary] and [least_energy]: motions whose end is given."""

from __future__ import annotations

from pydantic import Field

from .entry_types import Name, Table, Time, Values


class EndTable(Table):
    """Values at one end."""

    displacement: Values = Field({}, description="Positions or angles.")
    velocity: Values = Field({}, description="Velocities.")
    acceleration: Values = Field({}, description="Accelerations, for equations of degree 3 and above.")
    state: Values = Field({}, description="States of a state space, instead of all these, e.g. { x1 = 0.1 }.")


class BoundaryTable(Table):
    """Two-point boundary values: some values just after t = 0, others just before T; what is left out is free."""

    start: EndTable = Field(EndTable.model_construct(), description="Values just after t = 0, in the place of [initial].")
    end: EndTable = Field(EndTable.model_construct(), description="Values just before the end T.")
    duration: Time = Field(gt=0, description="T, the time between start and end.")


class LeastEnergyTable(Table):
    """The input u of least energy, the integral of u^2, that moves the model from [initial] to a state; it is zero after T."""

    inputs: list[Name] | None = Field(
        None, description="Coordinates, each with a force on it, or inputs of the model; left out: all coordinates, or all inputs."
    )
    end: EndTable = Field(EndTable.model_construct(), description="The state at T; what is left out is 0.")
    duration: Time = Field(gt=0, description="T, the time between start and end.")
