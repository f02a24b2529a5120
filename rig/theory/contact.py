"""Contact of two spheres or of a sphere and a wall: closed forms of the normal collision.

A linear spring and dashpot whose force never pulls (Schwager and Poschel, Granular Matter 9 (2007)
465): the two part when the force, not the overlap, vanishes.
"""

import math

_BISECTIONS = 80
"""Halvings of an interval of length 1: below one rounding."""


def restitution(damping_ratio: float) -> float:
    """Return the coefficient of restitution for a damping ratio zeta = c/(2 sqrt(k m)).

    Source: Schwager and Poschel (2007), eq. 22, with beta = zeta w0, w^2 = w0^2 - beta^2.
    """
    zeta = damping_ratio
    if zeta == 0.0:
        return 1.0
    if zeta < 1.0:
        root = math.sqrt(1.0 - zeta * zeta)
        angle = math.atan2(2.0 * zeta * root, 2.0 * zeta * zeta - 1.0)
        return math.exp(-zeta / root * angle)
    if zeta == 1.0:
        return math.exp(-2.0)
    root = math.sqrt(zeta * zeta - 1.0)
    return math.exp(zeta / root * math.log((zeta - root) / (zeta + root)))


def contact_time(damping_ratio: float, stiffness: float, mass: float) -> float:
    """Return the duration of a collision, s: until the force vanishes.

    stiffness : N/m; mass : reduced mass of the two, kg; damping_ratio below 1
    """
    zeta = damping_ratio
    root = math.sqrt(1.0 - zeta * zeta)
    angle = math.atan2(2.0 * zeta * root, 2.0 * zeta * zeta - 1.0) if zeta > 0.0 else math.pi
    return angle / (root * math.sqrt(stiffness / mass))


def damping_ratio(coefficient: float) -> float:
    """Return the damping ratio whose restitution is `coefficient`, above 0 and up to 1."""
    if not 0.0 < coefficient <= 1.0:
        raise ValueError(f"restitution {coefficient}: above 0 and at most 1")
    if coefficient == 1.0:
        return 0.0
    # The restitution falls with the damping ratio, so that bisection finds the only root.
    low, high = 0.0, 1.0
    while restitution(high) > coefficient:
        high *= 2.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if restitution(middle) > coefficient:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def hertz_damping(coefficient: float) -> float:
    """Return the dashpot of a Hertz contact whose restitution is `coefficient`, at any velocity.

    The dashpot is c in F = k x^1.5 + c sqrt(k m sqrt(x)) x', which never pulls. With s = x^1.25 and
    dtau = x^0.25 sqrt(0.8 k/m) dt, the motion is that of a linear contact of damping ratio
    c/sqrt(5), in whose units the velocity is the same and the force vanishes at the same place.
    Source: Antypov and Elliott, EPL 94 (2011) 50004, who let the contact pull.
    """
    return math.sqrt(5.0) * damping_ratio(coefficient)


def hertz_contact_time(stiffness: float, mass: float, velocity: float) -> float:
    """Return the duration of an elastic Hertz collision, s.

    stiffness : 4/3 E* sqrt(R*), N/m^1.5; mass : reduced mass, kg; velocity : of approach, m/s
    Source: Johnson, Contact Mechanics (1985), eq. 11.24: 2.87 (m^2/(R E*^2 v))^(1/5), here exact.
    """
    deepest = hertz_overlap(stiffness, mass, velocity)
    # 2 int_0^1 dx/sqrt(1 - x^2.5) = (4/5) sqrt(pi) Gamma(2/5)/Gamma(9/10)
    turn = 0.8 * math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9)
    return turn * deepest / velocity


def hertz_overlap(stiffness: float, mass: float, velocity: float) -> float:
    """Return the largest overlap of an elastic Hertz collision, m: (5 m v^2/(4 k))^(2/5)."""
    return float((1.25 * mass * velocity**2 / stiffness) ** 0.4)
