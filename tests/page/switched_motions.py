"""Motions with events for the tests of pages."""

import mbconstrained as mb


def ball() -> mb.SwitchedMotion:
    """A ball that bounces until it rests."""
    model = mb.LumpedModel()
    model.mass("ball", 1.0), model.gravity(-9.81)
    model.contact("ground", "ball", gap=0.5, restitution=0.5)
    return model.assemble().solve({"ball": 0.5}, end=2.0)


def stick_slip() -> mb.SwitchedMotion:
    """A block on a belt."""
    model = mb.LumpedModel()
    model.mass("block", 1.0), model.mass("belt", 1e3), model.spring("ground", "block", 100.0)
    model.dry_friction("belt", "block", normal_force=10.0, coefficient=0.3, static_coefficient=0.4)
    return model.assemble().solve(velocity={"belt": 0.1}, end=4.0)


def hanging() -> mb.SwitchedMotion:
    """A load on a cable below a hook, which becomes slack."""
    model = mb.LumpedModel()
    model.mass("load", 2.0), model.mass("hook", 1.0), model.gravity(-9.81)
    model.spring("ground", "hook", 400.0), model.damper("ground", "hook", 2.0)
    model.cable("hook", "load", length=-0.5, stiffness=2000.0)
    return model.assemble().solve({"load": -0.4}, end=1.5)


def driveline() -> mb.SwitchedMotion:
    """An engine whose clutch slips until both speeds are one."""
    model = mb.LumpedModel()
    model.inertia("engine", 0.2), model.inertia("gearbox", 1.5), model.torsion_damper("ground", "gearbox", 0.1)
    model.clutch("engine", "gearbox", torque=200.0, engaged=0.5)
    return model.assemble().solve(velocity={"engine": 100.0}, end=2.0)


def rattle() -> mb.SwitchedMotion:
    """Two bodies with a small play between them."""
    model = mb.LumpedModel()
    model.inertia("motor", 0.1), model.inertia("load", 0.2)
    model.backlash("motor", "load", gap=0.02, stiffness=500.0)
    return model.assemble().solve(velocity={"motor": 1.0}, end=0.5)
