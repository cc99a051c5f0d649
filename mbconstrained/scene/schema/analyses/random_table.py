"""The table [random]: spectra of forces and supports, and the outputs with their statistics."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from ....frequency.random.spectra import Spectrum, kanai_tajimi, psd, road_profile, white_noise
from ....ground.errors import InputError, shown
from ....ground.quantities import quantity
from ..entry_types import NUMBER_SCHEMA, Number, Table, Text, Time, quantity_field, ratios

Speed = quantity_field("m/s")
Frequency = quantity_field("Hz")

#: The kinds of spectra, one key each.
KINDS = ("values", "white", "road", "soil")


def _corner_frequencies(value):
    if not isinstance(value, list):
        raise InputError(f'found {shown(value)}; expected an array of frequencies, e.g. ["10 Hz", "2000 Hz"]')
    return [quantity(entry, "Hz") for entry in value]


def _numbers(value):
    if not isinstance(value, list):
        raise InputError(f"found {shown(value)}; expected an array of numbers in the unit of the density")
    return [quantity(entry, "1") for entry in value]


class RoadTable(Table):
    """A road of ISO 8608."""

    road_class: Literal["A", "B", "C", "D", "E", "F", "G", "H"] = Field(alias="class", description="A (very good) to H.")
    speed: Speed = Field(gt=0, description='Of the vehicle, e.g. "20 m/s".')  # type: ignore[valid-type]


class SoilTable(Table):
    """The spectrum of Kanai and Tajimi: white noise filtered by a layer of soil."""

    intensity: Number = Field(gt=0, description="Intensity of the acceleration of the rock, one-sided, in the unit of the density.")
    frequency: Frequency = Field(2.5, gt=0, description="Natural frequency of the soil.")  # type: ignore[valid-type]
    damping_ratio: Number = Field(0.6, gt=0, description="Damping ratio of the soil.")


class RandomInputTable(Table):
    """A random force, or the random motion of a support."""

    on: Text = Field(description="A coordinate, for a force on it, or a [[motion]] or constraint row, for its motion.")
    of: Literal["force", "displacement", "velocity", "acceleration"] = Field("force", description="Quantity of the density.")
    frequencies: Annotated[Any, BeforeValidator(_corner_frequencies), WithJsonSchema({"type": "array", "items": NUMBER_SCHEMA})] = (
        Field(None, description="Corner frequencies of a table, ascending.")
    )
    values: Annotated[Any, BeforeValidator(_numbers), WithJsonSchema({"type": "array", "items": NUMBER_SCHEMA})] = Field(
        None, description="The one-sided density at the corners."
    )
    unit: Text | None = Field(None, description='Of the density, e.g. "g^2/Hz"; SI when left out.')
    interpolation: Literal["log-log", "linear", "steps"] = Field("log-log", description="Between the corners.")
    white: Number | None = Field(None, gt=0, description="Intensity of white noise, instead of a table.")
    road: RoadTable | None = Field(None, description="Road profile of ISO 8608 (displacement), instead of a table.")
    soil: SoilTable | None = Field(None, description="Ground acceleration of Kanai and Tajimi, instead of a table.")
    delay: Time = Field(0.0, description="The process of the other inputs, later.")

    @model_validator(mode="after")
    def _one_kind(self):
        given = [key for key in KINDS if getattr(self, key) is not None]
        if len(given) != 1:
            raise InputError(
                f"found {' and '.join(given) or 'no spectrum'}; expected one of values (with frequencies), white, road or soil"
            )
        if (self.frequencies is None) != (self.values is None):
            raise InputError("frequencies and values belong together: give both for a table")
        return self

    @property
    def spectrum(self) -> Spectrum:
        """The one-sided density."""
        if self.white is not None:
            return white_noise(self.white, self.of, self.unit)
        if self.road is not None:
            return road_profile(self.road.road_class, self.road.speed)
        if self.soil is not None:
            return kanai_tajimi(self.soil.intensity, self.soil.frequency, self.soil.damping_ratio, self.unit)
        return psd(self.frequencies, self.values, self.of, self.unit, self.interpolation)


class RandomTable(Table):
    """The stationary response to random forces and random motions of supports."""

    input: list[RandomInputTable] = Field(min_length=1, description="The random inputs, [[random.input]].")
    outputs: list[Text] | None = Field(
        None, description="Coordinates; constraint rows for reactions, springs and dampers for forces; left out: all."
    )
    quantity: Literal["displacement", "velocity", "acceleration", "reaction", "force"] = Field(
        "displacement", description="Quantity of the outputs; force: of springs and dampers."
    )
    relative_to: Text | None = Field(None, description="A coordinate or prescribed motion, subtracted from the outputs.")
    coherence: Number | None = Field(
        None,
        ge=0,
        le=1,
        description="Ordinary coherence of all inputs; independent when left out, coherent where they have delays.",
    )
    duration: Time = Field(60.0, gt=0, description="Duration for the expected largest value.")
    modal_damping: Annotated[
        Any,
        BeforeValidator(ratios),
        WithJsonSchema({"anyOf": [*NUMBER_SCHEMA["anyOf"], {"type": "array", "items": NUMBER_SCHEMA}]}),
    ] = Field(None, description="Damping ratios in addition to that of the model.")
