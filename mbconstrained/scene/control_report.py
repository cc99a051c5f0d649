"""What a transfer function or state space tells besides its motion: zeros, gains, its normal form, jumps of its outputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..checks import counted
from ..models.transfer import roots_of
from ..response.transfer.rational import shown as polynomial_text
from .happenings import impulses_of, jumps_of, number, sized
from .text_table import TextTable
from .values import Coordinates

if TYPE_CHECKING:
    from ..models.transfer import Transfer
    from .control import ControlScene

MOST_CHANNELS = 16  # pairs of inputs and outputs that are listed; JSON has all
MOST_ZEROS = 8  # of one channel that are listed

HIDDEN, NOT_LOOKED_FOR, POLE_AT_ZERO, NOT_KNOWN = "hidden by rounding", "not looked for", "none: a pole at 0", "not known"


def control_tables(found: ControlScene | None) -> list[TextTable]:
    """Transfer functions and the normal form; nothing for other scenes."""
    if found is None:
        return []
    return [_transfer_table(found), *([_form_table(found), _output_table(found)] if found.form is not None else [])]


def control_facts(found: ControlScene | None) -> tuple[tuple[str, str], ...]:
    """The transfer function as it was given; nothing for other scenes."""
    if found is None or found.transfer_function is None:
        return ()
    fraction = found.transfer_function.fraction
    return (("transfer function", f"({polynomial_text(fraction.numerator)}) / ({polynomial_text(fraction.denominator)})"),)


def control_json(found: ControlScene | None) -> dict:
    """Inputs, outputs, transfer functions and normal form as plain data; nothing for other scenes."""
    if found is None:
        return {}
    data = {key: _units_json(getattr(found, key)) for key in ("inputs", "outputs")}
    data["transfer_functions"] = [
        {"input": u, "output": y, "dc_gain": dc_gain(found, u, y, G), **_transfer_json(G)} for u, y, G in found.transfers
    ]
    return data | ({"normal_form": _form_json(found.form)} if found.form is not None else {})


def _units_json(names: Coordinates) -> list[dict[str, str]]:
    return [{"name": name, "unit": unit} for name, unit in zip(names.names, names.units)]


def _transfer_json(G: Transfer | None) -> dict:
    if G is None:
        return {"zeros": None, "poles": None, "gain": None}
    roots = {key: [[z.real, z.imag] for z in roots_of(found)] for key, found in (("zeros", G.zeros), ("poles", G.poles))}
    return {**roots, "gain": G.gain}


def _form_json(form) -> dict:
    matrices = ("transformation", "stiffness", "damping", "input_matrix", "output_matrix", "feedthrough")
    found = {key: None if getattr(form, key) is None else getattr(form, key).tolist() for key in matrices}
    return {**found, "condition": form.condition, "unique": form.is_unique, "freedom": form.freedom}


def _transfer_table(found: ControlScene) -> TextTable:
    """Zeros and gains by input and output."""
    units = {name: unit for names in (found.inputs, found.outputs) for name, unit in zip(names.names, names.units)}
    rows = [(u, y, *_cells(found, u, y, G, _quotient(units[y], units[u]))) for u, y, G in found.transfers[:MOST_CHANNELS]]
    note = "G(s) = gain times the product of s - zeros over that of s - poles; the DC gain is G(0)."
    if len(found.transfers) > MOST_CHANNELS:
        note += f" The first {MOST_CHANNELS} of {len(found.transfers)} are shown."
    return TextTable("Transfer functions", ("from", "to", "zeros (1/s)", "gain", "DC gain"), tuple(rows), note)


def _cells(found: ControlScene, input: str, output: str, G: Transfer | None, unit: str) -> tuple[str, str, str]:
    dc = dc_gain(found, input, output, G)
    told = sized(dc, unit) if dc is not None else POLE_AT_ZERO if G is not None else NOT_KNOWN
    if G is None:
        return HIDDEN if found.looks_for_zeros else NOT_LOOKED_FOR, "", told
    return (_roots(G.zeros), number(G.gain), told) if G.gain else ("G(s) = 0", "0", "0")


def dc_gain(found: ControlScene, input: str, output: str, G: Transfer | None) -> float | None:
    """G(0), also where the zeros of G are not known."""
    if G is not None:
        return G.dc_gain
    gains = found.dc_gains
    return None if gains is None else float(gains[found.outputs.names.index(output), found.inputs.names.index(input)])


def _roots(zeros: Sequence) -> str:
    texts = [_root(complex(zero.value)) + (f" ({zero.multiplicity} times)" if zero.multiplicity > 1 else "") for zero in zeros]
    more = [f"{len(texts) - MOST_ZEROS} more"] if len(texts) > MOST_ZEROS else []
    return ", ".join(texts[:MOST_ZEROS] + more) or "none"


def _root(value: complex) -> str:
    if not value.imag:
        return number(value.real)
    return f"{number(value.real)} ± {number(value.imag)} i" if value.real else f"± {number(value.imag)} i"


def _quotient(above: str, below: str) -> str:
    """A unit by another, as it is printed.

    >>> _quotient("m", "V"), _quotient("m", "1"), _quotient("m", "m"), _quotient("rad", "N*m")
    ('m/V', 'm', '1', 'rad/(N*m)')
    """
    if below in ("1", above):
        return above if below == "1" else "1"
    return f"{above}/({below})" if {"*", "/"} & set(below) else f"{above}/{below}"


def _form_table(found: ControlScene) -> TextTable:
    """How the states became displacements and velocities."""
    form = found.form
    choice = "there is no other" if form.is_unique else f"one of a family of {form.freedom} dimensions, of small condition"
    rows = [("transformation", f"{2 * form.size} states to {counted(form.size, 'displacement')} and as many velocities; {choice}")]
    rows += [(item.name, f"{item.value:.2g}: {item.text}") for item in form.evidence]
    return TextTable("Mechanical normal form", ("what", "value"), tuple(rows))


def _output_table(found: ControlScene) -> TextTable:
    """Jumps and impulses of the outputs at t = 0; those of the displacements have tables of their own."""
    response, names = found.response, found.outputs.names
    together = response.together
    units = tuple(found.system.units[name] for name in together.polynomial_matrix.coordinates)
    everything = Coordinates(together.polynomial_matrix.coordinates, units)
    jumps = [jump for jump in jumps_of(together, everything) if jump.name in names]
    rows = [(jump.name, "jumps", jump.before, jump.after, jump.size) for jump in jumps]
    found_impulses = impulses_of(response.output_impulses, names, found.outputs.units)
    rows += [(impulse.name, f"multiplies δ{'′' * impulse.order}", "", "", impulse.size) for impulse in found_impulses]
    return TextTable("Outputs at t = 0", ("of", "what", "before", "after", "size"), tuple(rows))
