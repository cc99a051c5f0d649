"""The table [shock]: the shock response spectrum of a support's motion, and the duration of the search for peaks of the model."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from ....ground.errors import InputError
from ..entry_types import NUMBER_SCHEMA, Number, Table, Text, Time
from .frequency_table import AnyFrequency, frequency_lines

ShockQuantity = Literal[
    "absolute acceleration", "relative displacement", "relative velocity", "pseudo-velocity", "pseudo-acceleration"
]


class ShockTable(Table):
    """Peaks of the model, and of single oscillators on its support (the shock response spectrum)."""

    of: Text | None = Field(None, description="The [[motion]] whose acceleration is the shock; by default the first that ends.")
    end: Time | None = Field(None, gt=0, description="Until when peaks of the model are searched; by default time.end.")
    damping_ratio: Number = Field(0.05, ge=0, description="Damping ratio of the oscillators.")
    quality_factor: Number | None = Field(None, gt=0, description="Alternatively: Q = 1 / (2 damping ratio).")
    quantity: ShockQuantity = Field("absolute acceleration", description="Response quantity of the oscillators.")
    lowest: AnyFrequency | None = Field(
        None, alias="from", gt=0, description="The lowest natural frequency; by default a tenth of the inverse duration."
    )
    highest: AnyFrequency | None = Field(None, alias="to", gt=0, description="The highest natural frequency.")
    per_octave: int = Field(12, ge=1, le=96, description="Natural frequencies in each octave.")
    frequencies: Annotated[
        Any, BeforeValidator(frequency_lines), WithJsonSchema({"type": "array", "items": NUMBER_SCHEMA, "title": "frequencies"})
    ] = Field(None, description="Explicit list of natural frequencies.")
    interpolation: Literal["linear", "band-limited"] = Field("linear", description="Interpolation of a record between its samples.")
    tripartite: bool = Field(
        False, description="The pseudo-velocity, too, with lines of equal displacement and of equal acceleration."
    )

    @model_validator(mode="after")
    def _one_of_each(self):
        if self.quality_factor is not None and "damping_ratio" in self.model_fields_set:
            raise InputError("damping_ratio and quality_factor cannot both be given; leave out one of them")
        if self.frequencies is not None and (given := {"lowest", "highest", "per_octave"} & self.model_fields_set):
            names = {"lowest": "from", "highest": "to"}
            raise InputError(f"frequencies and {names.get(min(given), min(given))} cannot both be given; leave out one of them")
        if self.frequencies is not None and not min(self.frequencies) > 0:
            raise InputError("frequencies: found 0 Hz; expected positive natural frequencies")
        if self.lowest is not None and self.highest is not None and self.lowest >= self.highest:
            raise InputError(f"from is {self.lowest:g} Hz and to {self.highest:g} Hz; expected a range that ascends")
        return self

    def lines(self, lowest: float, highest: float) -> np.ndarray:
        """The natural frequencies in Hz, shape (F,)."""
        if self.frequencies is not None:
            return np.array(self.frequencies)
        low, high = self.lowest or lowest, self.highest or highest
        if not low < high:
            low, high = (low, 1e3 * low) if self.lowest else (high / 1e3, high)
        return np.geomspace(low, high, int(np.ceil(self.per_octave * np.log2(high / low))) + 1)
