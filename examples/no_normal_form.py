"""What is said of state-space models that no change of states makes mechanical, q'' + C q' + K q = [0; I] u.

Run it with ``python examples/no_normal_form.py``.
"""

import mbconstrained as mb

CASES = {
    "the input changes no velocity but a state directly": (
        [[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0], [1, 1, 1, 2]],
        [[0], [0], [0], [1]],
    ),
    "two states grow alike, each by itself, and the input reaches neither": (
        [[5, 0, 0, 0], [0, 5, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0]],
        [[0], [0], [0], [1]],
    ),
}


def main() -> None:
    """Try each and print why it cannot be done."""
    for name, (A, B) in CASES.items():
        try:
            mb.mechanical_normal_form(A, B)
        except mb.NoNormalForm as problem:
            print(f"{name}:\n  {problem}")


if __name__ == "__main__":
    main()
