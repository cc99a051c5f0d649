"""The table [frequency]: quantity, frequencies and plots of the frequency response."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import BeforeValidator, Field, PlainValidator, WithJsonSchema, model_validator

from ....ground.errors import InputError, shown
from ....ground.quantities import quantity
from ..entry_types import NUMBER_SCHEMA, QUANTITY_SCHEMA, Table, Text, ratios

ResponseQuantity = Literal[
    "receptance",
    "mobility",
    "accelerance",
    "dynamic stiffness",
    "impedance",
    "apparent mass",
    "transmissibility",
    "reaction",
    "force",
]
ResponsePlot = Literal["bode", "parts", "nyquist"]


def _loss_factors(value):
    if isinstance(value, dict):
        return {name: quantity(factor, "1") for name, factor in value.items()}
    return quantity(value, "1")


def _frequency(value) -> float:
    """A frequency in Hz; an angular velocity is converted by 1 / (2 pi)."""
    try:
        return float(quantity(value, "Hz"))
    except InputError as problem:
        try:
            return float(quantity(value, "rad/s")) / (2 * math.pi)
        except InputError:
            raise problem from None


AnyFrequency = Annotated[
    float,
    PlainValidator(_frequency),
    WithJsonSchema({"unit": "Hz", "examples": ["2 Hz", "600 rpm"], "anyOf": [{"type": "number"}, QUANTITY_SCHEMA]}),
]


def frequency_lines(value):
    """A list of distinct frequencies in Hz, ascending."""
    if not isinstance(value, list) or not value:
        raise InputError(f'found {shown(value)}; expected an array of frequencies, e.g. ["1 Hz", "2.5 Hz"]')
    lines = [_frequency(entry) for entry in value]
    if (bad := min(lines)) < 0:
        raise InputError(f"found {bad:g} Hz; expected frequencies of at least 0")
    return sorted(set(lines))


class FrequencyTable(Table):
    """Steady response to harmonic loads and prescribed motions over the frequency."""

    MOST_LINES: ClassVar[int] = 100_000

    inputs: list[Text] | None = Field(
        None, description="Coordinates, each a force on it, or names of [[motion]] tables and constraint rows; by default all motions, "
        "or else the loaded coordinates."
    )  # fmt: skip
    outputs: list[Text] | None = Field(
        None, description="Coordinates, of reactions constraint rows, of forces springs and dampers; left out: all, and the springs and "
        "dampers of [[output.quantity]]."
    )  # fmt: skip
    quantity: ResponseQuantity = Field("receptance", description="Kind of response: receptance (displacement / force), …")
    relative_to: Text | None = Field(
        None, description="A coordinate or prescribed motion, subtracted from the outputs of its unit."
    )
    lowest: AnyFrequency | None = Field(
        None, alias="from", ge=0, description="The lowest frequency; by default a decade below the lowest pole."
    )
    highest: AnyFrequency | None = Field(
        None, alias="to", gt=0, description="The highest frequency; by default a decade above the highest pole."
    )
    spacing: Literal["auto", "linear", "log"] = Field(
        "auto", description="auto: placed by the poles, so that no peak is missed; or even steps of the frequency or its logarithm."
    )
    points: int | None = Field(None, ge=2, le=MOST_LINES, description="Number of evenly spaced frequencies; 401 by default.")
    frequencies: Annotated[
        Any, BeforeValidator(frequency_lines), WithJsonSchema({"type": "array", "items": NUMBER_SCHEMA, "title": "frequencies"})
    ] = Field(None, description="Explicit list of frequencies.")
    modal_damping: Annotated[
        Any,
        BeforeValidator(ratios),
        WithJsonSchema({"anyOf": [*NUMBER_SCHEMA["anyOf"], {"type": "array", "items": NUMBER_SCHEMA}]}),
    ] = Field(None, description="Damping ratios in addition to that of the model: one for all modes, or one for each.")
    loss_factor: Annotated[
        Any,
        BeforeValidator(_loss_factors),
        WithJsonSchema({"anyOf": [*NUMBER_SCHEMA["anyOf"], {"type": "object", "additionalProperties": NUMBER_SCHEMA}]}),
    ] = Field(None, description="Structural damping K (1 + i eta): eta of the model, or by the names of springs.")
    plots: list[ResponsePlot] = Field(
        ["bode"], description="Amplitude and phase; real and imaginary part; one over the other (Nyquist)."
    )
    amplitude: Literal["log", "linear", "dB"] = Field("log", description="The axis of the amplitude.")
    phase: Literal["unwrapped", "wrapped"] = Field("unwrapped", description="wrapped: from -180 to 180 degrees.")
    axis: Literal["Hz", "rad/s", "rpm"] = Field("Hz", description="The unit of the frequency on the page and in tables.")

    @model_validator(mode="after")
    def _one_range(self):
        of_range = [key for name, key in self._range_keys if name in self.model_fields_set]
        if self.frequencies is not None and of_range:
            raise InputError(f"frequencies and {of_range[0]} cannot both be given; leave out one of them")
        if self.highest is not None and (self.lowest or 0.0) >= self.highest:
            raise InputError(f"from is {self.lowest:g} Hz and to {self.highest:g} Hz; expected a range that ascends")
        if self.spacing == "auto":
            if self.points is not None:
                raise InputError('points needs spacing = "linear" or "log"; with "auto" the poles decide how many there are')
        elif self.lowest is None or self.highest is None:
            raise InputError(f'spacing = "{self.spacing}" needs the range: give from and to, e.g. from = "1 Hz", to = "200 Hz"')
        elif self.spacing == "log" and not self.lowest:
            raise InputError("from is 0 Hz; even steps of the logarithm need a positive lowest frequency")
        return self

    _range_keys: ClassVar = (("lowest", "from"), ("highest", "to"), ("spacing", "spacing"), ("points", "points"))

    @property
    def is_auto(self) -> bool:
        """Whether the poles place the frequencies."""
        return self.frequencies is None and self.spacing == "auto"

    @property
    def lines(self) -> np.ndarray:
        """The frequencies in Hz, where the poles do not place them, shape (F,)."""
        if self.frequencies is not None:
            return np.array(self.frequencies)
        spaced = np.geomspace if self.spacing == "log" else np.linspace
        return spaced(self.lowest, self.highest, self.points or 401)
