"""The report on state-space models that have no mechanical normal form, q'' + C q' + K q = [0; I] u.

Run it with ``python examples/no_normal_form.py``.
"""

import mbconstrained as mb

CASES = {
    "the input acts on a state that is no velocity": (
        [[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0], [1, 1, 1, 2]],
        [[0], [0], [0], [1]],
    ),
    "two uncoupled states with equal growth that the input does not excite": (
        [[5, 0, 0, 0], [0, 5, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0]],
        [[0], [0], [0], [1]],
    ),
}


def main() -> None:
    """Try each and print the failed condition."""
    for name, (A, B) in CASES.items():
        try:
            mb.mechanical_normal_form(A, B)
        except mb.NoNormalForm as problem:
            print(f"{name}:\n  {problem}")


if __name__ == "__main__":
    main()
