"""A joint whose gear is elastic: between the motor and the link sits a spring (Spong's model)."""

from __future__ import annotations

from dataclasses import dataclass, fields

from ...checks import real_number


@dataclass(frozen=True)
class FlexibleJoint:
    """A motor that drives a joint through an elastic gear, its angle theta measured behind the gear:

        B theta'' + (k + c d/dt) (theta - q) + k_d theta' + k_p theta = tau,        B = gear_ratio^2 motor_inertia

    theta and q being deviations from the equilibrium; on the joint acts (k + c d/dt) (theta - q). The rotor's inertia
    about its own axis is all that is taken from it (its mass belongs to the link that carries it). For a joint that slides
    read N for N m and m for rad.

    Attributes:
        stiffness: k (N m/rad), greater than zero.
        damping: c (N m s/rad).
        motor_inertia: of the rotor, in front of the gear (kg m^2).
        gear_ratio: turns of the motor for one of the joint.
        proportional_gain, derivative_gain: k_p and k_d of the motor's position control, at the joint's side
            (N m/rad, N m s/rad).

    >>> FlexibleJoint(stiffness=8000.0, motor_inertia=1e-4, gear_ratio=100).reflected_inertia
    1.0
    """

    stiffness: float
    damping: float = 0.0
    motor_inertia: float = 0.0
    gear_ratio: float = 1.0
    proportional_gain: float = 0.0
    derivative_gain: float = 0.0

    def __post_init__(self):
        for field in fields(self):
            limits = {"positive": True} if field.name in ("stiffness", "gear_ratio") else {"minimum": 0.0}
            what = f"flexible joint: {field.name.replace('_', ' ')}"
            object.__setattr__(self, field.name, real_number(getattr(self, field.name), what, **limits))

    @property
    def reflected_inertia(self) -> float:
        """B, the rotor's inertia as the joint feels it (kg m^2)."""
        return self.motor_inertia * self.gear_ratio**2
