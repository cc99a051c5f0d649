"""Names of others as identifiers of Python and C, and as LaTeX: valid, distinct, and never more than names."""

from __future__ import annotations

import keyword
import re
import unicodedata
from collections.abc import Iterable

from sympy.printing.c import reserved_words
from sympy.printing.pretty.pretty_symbology import greek_letters, greek_unicode

#: Words of C beyond those of sympy's printer: C99, C23, and common extensions of compilers.
C_KEYWORDS = frozenset(reserved_words) | set(
    "asm bool complex false fortran imaginary inline linux main nullptr restrict true typeof unix".split()
)
#: Names of math.h, which a variable would hide.
C_NAMES = frozenset(
    "acos asin atan atan2 cos sin tan acosh asinh atanh cosh sinh tanh exp exp2 expm1 frexp ilogb ldexp log log10 log1p log2 logb "
    "modf cbrt fabs hypot pow sqrt erf erfc lgamma tgamma ceil floor nearbyint rint round trunc fmod remainder nan fdim fmax fmin "
    "fma j0 j1 jn y0 y1 yn gamma signgam div abs labs NAN INFINITY HUGE HUGE_VAL HUGE_VALF HUGE_VALL MATH_ERRNO MATH_ERREXCEPT "
    "OVERFLOW UNDERFLOW DOMAIN SING PLOSS TLOSS MAXFLOAT X_TLOSS".split()
)
C_MACROS = re.compile(r"(M|FP)_[A-Z0-9_]+")  # M_E, M_PI, FP_NAN, … of math.h
PYTHON_NAMES = frozenset(("np", "t", "x", "value", "values"))
AMBIGUOUS = frozenset("lIO")  # which look like 1 and 0

_GREEK = ["lambda" if letter == "lamda" else letter for letter in greek_letters]
_LATEX_GREEK = frozenset([*_GREEK, "Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega"]) - {
    "omicron"
}
_INDEXED = re.compile(rf"([A-Za-z]|{'|'.join(sorted(_LATEX_GREEK))})_?([0-9]+|(?<=_)[A-Za-z0-9]+)")
LETTERS = {name: greek_unicode[name] for name in _LATEX_GREEK}  # by the names that are written for them
_LATEX_SPECIAL = {
    "\\": r"\backslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "_": r"\_", "%": r"\%",
    "^": r"\hat{}", "~": r"\sim{}", " ": r"\ ", "-": r"\text{-}", "'": "'",
}  # fmt: skip


def identifiers(names: Iterable[str], reserved: Iterable[str] = ()) -> dict[str, str]:
    """An identifier of both Python and C for each name, each different from the others and from the reserved ones.

    >>> identifiers(["k", "lambda", "left joint", "I", "θ1", "k_", "left.joint"])
    {'k': 'k', 'lambda': 'lambda_', 'left joint': 'left_joint', 'I': 'I_', 'θ1': 'theta1', 'k_': 'k_', 'left.joint': 'left_joint_2'}
    """
    names, used, chosen = list(dict.fromkeys(names)), set(reserved), {}
    for name in sorted(names, key=lambda name: identifier(name) != name):  # valid names are kept
        own = identifier(name)
        tries = (own, *(f"{own.rstrip('_')}_{number}" for number in range(2, len(names) + len(used) + 3)))
        chosen[name] = next(each for each in tries if each not in used)
        used.add(chosen[name])
    return {name: chosen[name] for name in names}


def identifier(name: str) -> str:
    """A valid identifier for a name.

    >>> identifier("2 wheels"), identifier("Ü"), identifier(""), identifier("class")
    ('v2_wheels', 'U', 'v', 'class_')
    """
    text = re.sub(r"[^A-Za-z0-9]+", "_", "".join(map(_ascii, name))).lstrip("_")
    text = text.rstrip("_") + ("_" if name.endswith("_") and text else "")
    if not text or text[0].isdigit():
        text = f"v{text}"
    reserved = keyword.iskeyword(text) or keyword.issoftkeyword(text) or text in C_KEYWORDS | C_NAMES | PYTHON_NAMES | AMBIGUOUS
    return f"{text}_" if reserved or C_MACROS.fullmatch(text) else text


def index_of(name: str) -> tuple[str, str]:
    """A letter, or the name of a Greek one, and the index behind it; the name and an empty text otherwise.

    >>> index_of("k12"), index_of("m_x"), index_of("omega1"), index_of("left")
    (('k', '12'), ('m', 'x'), ('omega', '1'), ('left', ''))
    >>> index_of("θ1")
    ('theta', '1')
    """
    name = spelled(name)
    parts = _INDEXED.fullmatch(name)
    return (parts[1], parts[2]) if parts else (name, "")


def spelled(name: str) -> str:
    """A name that begins with a Greek letter, with the name of the letter, where that and an index is all of it."""
    word = _ascii(name[:1]) if name and not name[0].isascii() else ""
    return word + name[1:] if word in LETTERS and re.fullmatch(r"[0-9_]*", name[1:]) else name


def latex_name(name: str) -> str:
    r"""A name as LaTeX: its letter, a Greek letter, a number behind it as an index, anything else upright.

    >>> latex_name("k1"), latex_name("alpha"), latex_name("left joint"), latex_name("m_x"), latex_name("a}{b")
    ('k_{1}', '\\alpha', '\\mathrm{left\\ joint}', 'm_{\\mathrm{x}}', '\\mathrm{a\\}\\{b}')
    """
    letter, index = index_of(name)
    if index:
        shown = index if index.isdigit() else rf"\mathrm{{{index}}}"
        return f"{latex_name(letter)}_{{{shown}}}"
    if letter in _LATEX_GREEK:
        return f"\\{letter}"
    if len(name) == 1 and name.isascii() and name.isalpha():
        return name
    return rf"\mathrm{{{''.join(map(_latex_letter, name))}}}"


def _latex_letter(letter: str) -> str:
    """A letter in math: Greek ones by their names, others beyond ASCII as text, which is what LaTeX knows them in."""
    if letter.isascii():
        return _LATEX_SPECIAL.get(letter, letter)
    word = _ascii(letter)
    return rf"\{word}{{}}" if word in _LATEX_GREEK else rf"\text{{{letter}}}"


def _ascii(letter: str) -> str:
    """ASCII for a letter: Greek ones by their names, accents left out, others by their numbers."""
    if letter.isascii():
        return letter
    words = unicodedata.name(letter, "").lower().split()
    if words[:1] == ["greek"] and words[3:4] and words[3] in (*_GREEK, "lamda"):
        word = "lambda" if words[3] == "lamda" else words[3]
        return word.capitalize() if words[1] == "capital" else word
    ascii_letters = unicodedata.normalize("NFKD", letter).encode("ascii", "ignore").decode()
    return ascii_letters or (f"u{ord(letter):x}" if letter.isalpha() else "_")
