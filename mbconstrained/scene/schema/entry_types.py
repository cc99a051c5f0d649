"""The types of entries in a scene file, and its validation, with the problems of pydantic in the words of a scene."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetPydanticSchema,
    PlainValidator,
    TypeAdapter,
    ValidationError,
    WithJsonSchema,
    WrapValidator,
    model_validator,
)
from pydantic_core import PydanticCustomError, core_schema

from ...ground.checks import nearest
from ...ground.errors import InputError, SceneError, quoted, shown
from ...ground.quantities import KINDS, quantity, unit_name
from ..file import EntryError, place, together

LONGEST_TEXT, MOST_POWER = 2000, 20
_NAME = re.compile(r"[^\W\d][\w .'()-]{0,39}")


ABOVE = ("title", "source", "include")  # keys that stand above all tables
MEANT = {  # what people write: what a scene calls it
    "position": "displacement", "speed": "velocity", "start": "initial", "duration": "end", "stop": "end", "steps": "points",
    "step": "points", "type": "kind", "body": "coordinate", "amplitude": "value", "ends": "between", "bodies": "between",
    "friction": "dry_friction", "unilateral": "contact", "gap": "contact", "bumper": "contact", "rope": "cable", "play": "backlash",
    "file": "robot", "urdf": "robot", "input": "coordinate", "preload": "rest_length", "shaft": "torsion_spring", "at": "on", "speeds": "from",
    "k": "stiffness", "c": "damping", "m": "mass", "weight": "mass", "length": "rest_length", "options": "output", "on": "coordinate", "node": "coordinate", "coordinate": "on",
}  # fmt: skip


DAMPING = {  # advice on the key damping, by a key that the table has
    "stiffness": "; a damper is an element of its own, a table [[model.damper]] or [[model.torsion_damper]] between the same",
    "modal_damping": "; write modal_damping = 0.05, or a table [model.rayleigh_damping]",
}


class UnknownKey(EntryError):
    """A key that a table does not have."""

    def __init__(self, key: str, known: Iterable[str], hint: str = ""):
        known = list(known)
        hint = hint or (f'; did you mean "{MEANT[key]}"?' if MEANT.get(key) in known else nearest(key, known))
        if not hint and {"parameters", "samples"} <= {*known}:  # [vary]
            hint = "; what varies stands by its name in parameters, below [vary.parameters]"
        if key in ABOVE:
            hint = f"; {key} = … stands at the top of the file, above the first [table]"
        if not hint and key == "damping":
            hint = next((advice for one, advice in DAMPING.items() if one in known), "")
        super().__init__(f"unknown key {shown(key)}{hint}; known here are {', '.join(known)}", key)


class Table(BaseModel):
    """A table of the scene file: it refuses unknown keys and names the nearest known one."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, arbitrary_types_allowed=True, defer_build=True)

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema, handler):
        cls.model_rebuild()  # a default of this class is written by its serializer, which earlier versions do not build themselves
        return handler(core_schema)

    @model_validator(mode="wrap")
    @classmethod
    def _validated(cls, data, handler):
        if isinstance(data, cls):
            return handler(data)
        if isinstance(data, list) and all(isinstance(entry, dict) for entry in data):
            raise InputError("there is one table of this kind only: write it with single brackets, […]")
        known = [field.alias or name for name, field in cls.model_fields.items()]  # Python keywords have another name as attributes
        if not isinstance(data, dict):
            raise InputError(f"found {shown(data)}; expected a table with the keys {', '.join(known)}")
        for key in data:
            if key not in known:
                raise UnknownKey(key, known, cls._hint(key))
        table = handler(data)
        table._check()
        return table

    def _check(self) -> None:
        """Check that the entries fit together, and complete those that follow from others."""

    @classmethod
    def _hint(cls, key: str) -> str:
        """Hint for a key that belongs to another table."""
        return ""


@dataclass(frozen=True)
class LateTable:
    """The type of a table whose class is created when a scene has it: all classes together take as long as most answers."""

    name: str  # of the class
    module: str = ".analysis_tables"

    @property
    def table(self) -> type[BaseModel]:
        return getattr(import_module(self.module, __package__), self.name)

    def __get_pydantic_core_schema__(self, source, handler):
        return core_schema.no_info_before_validator_function(
            lambda value: self.table.model_validate(value), core_schema.any_schema()
        )

    def __get_pydantic_json_schema__(self, schema, handler):
        return handler(core_schema.definitions_schema(_with_names(TypeAdapter(self.table).core_schema), []))


@dataclass(frozen=True)
class TablesByKind:
    """The type of a table whose class depends on its key kind, and is created when a scene has one of it."""

    table: Callable[[str], type[BaseModel]]  # the class of a kind
    kinds: tuple[str, ...]
    default: str | None = None  # the kind of tables without one

    def _validated(self, value):
        kind = value.get("kind", self.default) if isinstance(value, dict) else None
        if kind not in self.kinds:
            raise PydanticCustomError("union_tag_invalid", "not the kind of a table")
        return self.table(kind).model_validate({**value, "kind": kind})

    def __get_pydantic_core_schema__(self, source, handler):
        return core_schema.no_info_before_validator_function(self._validated, core_schema.any_schema())

    def __get_pydantic_json_schema__(self, schema, handler):
        def union(source, handler):
            return core_schema.tagged_union_schema({kind: handler.generate_schema(self.table(kind)) for kind in self.kinds}, "kind")

        return handler(_with_names(TypeAdapter(Annotated[Any, GetPydanticSchema(union)]).core_schema))


def _with_names(schema: Any, *, is_named: bool = False) -> Any:
    """A schema of pydantic in which each table has its name in $defs; pydantic leaves out those of tables that stand once."""
    if isinstance(schema, list):
        return [_with_names(entry) for entry in schema]
    if not isinstance(schema, dict):
        return schema
    table = schema["cls"] if schema.get("type") == "model" else None
    has_name = is_named or "ref" in schema
    named = {
        key: value if key == "metadata" else _with_names(value, is_named=has_name and table is None)
        for key, value in schema.items()
    }
    if table is None or has_name:
        return named
    return {"ref": f"{table.__module__}.{table.__qualname__}:{id(table)}", **named}


#: For editors: what a text that stands for a number looks like.
EXPRESSION_SCHEMA = {"type": "string", "pattern": r"^\s*=.+$", "title": '"=" and an expression of parameters'}
QUANTITY_SCHEMA = {
    "type": "string",
    "pattern": r"^\s*(=.+|[+-]?([0-9]+(_[0-9]+)*\.?([0-9]+(_[0-9]+)*)?|\.[0-9]+(_[0-9]+)*)([eE][+-]?[0-9]{1,3})?\s*(1/|[^\s0-9.,;=+*/()<>-]).*)$",
    "title": 'a number and a unit, or "=" and an expression of parameters',
}
NUMBER_SCHEMA = {"anyOf": [{"type": "number"}, QUANTITY_SCHEMA]}
NUMBERS_SCHEMA = {"type": "array", "items": NUMBER_SCHEMA}
RATIOS_SCHEMA = {"anyOf": [*NUMBER_SCHEMA["anyOf"], NUMBERS_SCHEMA]}


def quantity_field(unit: str):
    """The type of a key with a number in the SI unit or a text with a unit of the same kind."""
    text = EXPRESSION_SCHEMA if unit == "1" else QUANTITY_SCHEMA
    examples = ([] if unit == "1" else [KINDS[unit][1].strip('"')]) + ["=2*k"]
    schema = {"unit": unit, "examples": examples, "anyOf": [{"type": "number"}, text]}

    def number(value, check: Callable[[float], float]):
        """The number in SI, within the bounds of its field; an expression of parameters as it is, which pydantic would convert to a float."""
        result = quantity(value, unit)
        if isinstance(result, (int, float)):
            check(result)
        return result

    return Annotated[float, WrapValidator(number), WithJsonSchema(schema)]


Number = quantity_field("1")
Mass = quantity_field("kg")
Inertia = quantity_field("kg*m^2")
Eccentric = quantity_field("kg*m")
Length = quantity_field("m")
Velocity = quantity_field("m/s")
Acceleration = quantity_field("m/s^2")
Angle = quantity_field("rad")
AngularVelocity = quantity_field("rad/s")
Stiffness = quantity_field("N/m")
TorsionStiffness = quantity_field("N*m/rad")
Damping = quantity_field("N*s/m")
TorsionDamping = quantity_field("N*m*s/rad")
Time = quantity_field("s")
Frequency = quantity_field("Hz")
Rate = quantity_field("1/s")


def in_planes(unit: str):
    """The type of a key with a quantity, one for each of the planes y and z, a matrix of them, or a list of these."""

    def converted(value):
        return [converted(entry) for entry in value] if isinstance(value, list) else quantity(value, unit)

    title = "a quantity, two for the planes y and z, or two rows of two; with speeds a list of these"
    return Annotated[
        Any, BeforeValidator(converted), WithJsonSchema({"title": title, "anyOf": [*NUMBER_SCHEMA["anyOf"], {"type": "array"}]})
    ]


class RayleighTable(Table):
    """Proportional damping C = a M + b K, in addition to that of the dampers."""

    mass: Rate = Field(  # type: ignore[valid-type]
        0.0, ge=0, description='The factor a of the mass matrix, e.g. "0.4 1/s".'
    )
    stiffness: Time = Field(  # type: ignore[valid-type]
        0.0, ge=0, description='The factor b of the stiffness matrix, e.g. "2 ms".'
    )
    relative: bool | None = Field(
        None,
        description="Whether the part a M acts on velocities relative to moving supports; by default where a record or a random motion moves one.",
    )


def ratios(value):
    """A damping ratio, or one for each mode."""
    return [quantity(entry, "1") for entry in value] if isinstance(value, list) else quantity(value, "1")


Ratios = Annotated[Any, BeforeValidator(ratios), WithJsonSchema(RATIOS_SCHEMA)]


class DampedTable(Table):
    """A mechanical model, which may have damping of the model as a whole."""

    rayleigh_damping: RayleighTable | None = Field(None, description="Proportional (Rayleigh) damping, a M + b K.")
    modal_damping: Annotated[Ratios, WithJsonSchema({"title": "a ratio, or those of the lowest modes", **RATIOS_SCHEMA})] = Field(
        None, description="The damping ratio of all undamped modes, e.g. 0.02, or of the lowest ones, e.g. [0.02, 0.05]."
    )


#: The key of models that may switch.
LINEAR_PHASE: Any = Field(
    None,
    description="Of a model that switches, the phase for which modes, frequency responses and other linear analyses answer: its name, or "
    'states by the name of what switches, e.g. { stop = "closed" }; left out: that at the start.',
)

#: The key of models that may be rotors.
SPEED: Any = Field(None, description='The constant speed of a rotor, e.g. "3000 rpm"; left out: at rest.')


def _teeth(value):
    count = quantity(value, "1")
    if count != int(count) or count < 1:
        result = f", which is {float(value):g}" if hasattr(value, "text") else ""
        raise InputError(f"found {shown(value)}{result}; expected a whole number of teeth, e.g. 24")
    return count


Teeth = Annotated[
    float,
    PlainValidator(_teeth),
    WithJsonSchema({"title": "a whole number, or an expression", "anyOf": [{"type": "integer", "minimum": 1}, EXPRESSION_SCHEMA]}),
]


def number_or_text(value):
    """A quantity whose unit depends on the coordinate it belongs to: checked further once that is known."""
    return value if isinstance(value, str) else quantity(value, "1")


def _name(value):
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise InputError(
            f"found {shown(value)}; expected a name: a letter first, then at most 39 letters, digits, spaces or _ . ' ( ) -"
        )
    return value


def _text(value):
    if not isinstance(value, str):
        raise InputError(f"found {shown(value)}; expected a text in quotes")
    if len(value) > LONGEST_TEXT:
        raise InputError(f"found a text of {len(value)} characters; expected at most {LONGEST_TEXT}")
    bad = next((c for c in value if not (c.isprintable() or c == "\n")), None)
    if bad:
        raise InputError(f"found the character {quoted(bad)}, which cannot be printed; leave it out")
    return value


Quantity = Annotated[
    Any,
    BeforeValidator(number_or_text),
    WithJsonSchema({"title": 'a number in SI, a text with a unit, or "=" and an expression of parameters', **NUMBER_SCHEMA}),
]
Level = Literal["position", "velocity", "acceleration"]
Name = Annotated[str, BeforeValidator(_name)]
Unit = Annotated[str, BeforeValidator(unit_name)]
Text = Annotated[str, BeforeValidator(_text)]

#: A column of a file, by number or name.
Column = Annotated[int, Field(ge=1)] | Text
LinearPhase = dict[str, str] | str | None
Pair = Annotated[list[Name], Field(min_length=2, max_length=2)]
Vector = Annotated[list[Length], Field(min_length=3, max_length=3)]  # type: ignore[valid-type]


def _values(value):
    if not isinstance(value, (dict, list)):
        raise InputError(f'found {shown(value)}; expected {{ x1 = "0.8 m" }} or an array with a value for every coordinate')
    return value


VALUES_SCHEMAS = [{"type": "object", "additionalProperties": NUMBER_SCHEMA}, {"type": "array", "items": NUMBER_SCHEMA}]

Values = Annotated[
    Any, BeforeValidator(_values), WithJsonSchema({"title": "values by coordinate, or an array of all", "anyOf": VALUES_SCHEMAS})
]


#: Kinds of signals of forces and prescribed motions.
SIGNALS = ("step", "ramp", "power", "impulse", "harmonic", "term", "pulse", "sampled")
_ANY_SIGNAL = f"""{", ".join(f'"{kind}"' for kind in SIGNALS[:-1])} or "{SIGNALS[-1]}\""""
KINDS_OF_ENTRIES = {
    "model": '"lumped", "matrices", "robot", "state-space" or "transfer-function"',
    "force": _ANY_SIGNAL,
    "motion": _ANY_SIGNAL,
}

#: Common names of a kind: its name in scenes.
OTHER_NAMES = {"record": "sampled", "file": "sampled", "sine": "harmonic", "cosine": "harmonic", "constant": "step"}

#: Wrong entries that get a sentence, of which the first ones are shown; what is meant by each is searched for among all names.
MOST_EXPLAINED = 100

MISSING = {
    "model": 'this table is missing: write [model], and below it kind = "lumped", "matrices", …',
}

MISSING_TIME = 'time: this table is missing, and a motion needs it: write [time], and below it end = "10 s"'


def validated(data: dict, file_name: str, schema: type[BaseModel]):
    """The tables of a scene, or of another file with its schema, validated."""
    try:
        return schema.model_validate(data)
    except ValidationError as error:
        errors = error.errors()
        places = ((problem, place(problem["loc"], data)) for problem in errors[:MOST_EXPLAINED])
        problems = [(f"{where}: {_sentence(one, where)}", one.get("ctx", {}).get("error")) for one, where in places]
    raise SceneError(together(file_name, problems, len(errors) - len(problems)))


def _sentence(problem: Mapping[str, Any], where: str) -> str:
    kind, context, value = problem["type"], problem.get("ctx", {}), problem["input"]
    if kind == "value_error":
        return str(context["error"])
    if kind == "missing":
        return MISSING.get(where, "this key is missing")
    if kind == "union_tag_invalid":
        return _kind_sentence(value, problem["loc"][0])
    if kind == "literal_error":
        return _choice(value, context["expected"].replace("'", '"'))
    if kind == "list_type" and isinstance(value, dict):
        return f"found one table; write it with double brackets, [[{where}]], once for every entry"
    example = f", such as [{shown(value)}]" if kind == "list_type" and isinstance(value, str) else ""
    return f"found {shown(value)}; {_expectation(kind, context) or problem['msg']}{example}"


def _kind_sentence(value, where: str) -> str:
    known = KINDS_OF_ENTRIES[where]
    if isinstance(value, list) and value:
        return f"there is one {where} only: write it with single brackets, [{where}]"
    if not isinstance(value, dict):
        return f"found {shown(value)}; expected a table with the key kind = {known}"
    if "kind" not in value:
        return f"the key kind is missing; expected {known}"
    return "kind: " + _choice(value["kind"], known)


def _choice(value, known: str) -> str:
    names = re.findall(r'"([^"]*)"', known)
    meant = OTHER_NAMES.get(value) if isinstance(value, str) else None
    hint = f'; did you mean "{meant}"?' if meant in names else nearest(value, names) if isinstance(value, str) else ""
    return f"found {shown(value)}; expected {known}{hint}"


def _limit(context: dict, key: str) -> str:
    return f"{context.get(key, 0):g}"


def _expectation(kind: str, context: dict) -> str:
    return {
        "list_type": "expected an array [ … ]",
        "dict_type": "expected a table",
        "bool_type": "expected true or false",
        "int_type": "expected a whole number",
        "int_from_float": "expected a whole number",
        "float_type": "expected a number",
        "finite_number": "expected a finite number",
        "string_type": "expected a text in quotes",
        "tuple_type": "expected an array [ … ]",
        "string_too_short": f"expected at least {context.get('min_length')} letters",
        "string_too_long": f"expected at most {context.get('max_length')} letters",
        "too_short": f"expected at least {context.get('min_length')} entries",
        "too_long": f"expected at most {context.get('max_length')} entries",
        "greater_than": f"expected more than {_limit(context, 'gt')}",
        "less_than": f"expected less than {_limit(context, 'lt')}",
        "greater_than_equal": f"expected at least {_limit(context, 'ge')}",
        "less_than_equal": f"expected at most {_limit(context, 'le')}",
    }.get(kind, "")
