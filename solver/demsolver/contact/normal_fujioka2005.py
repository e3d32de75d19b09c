"""Energy-conserving contact of Fujioka & Ushijima (2005), a reconstruction: their paper of 2006 tells of it in words only.

With a = kn dt^2/meff and s = u/d (u the approach per step, d the overlap), u' and d' the next ones, per pair with the reduced mass 1:

    s >= 1/e                       the contact step is the only one: u' = -e u
    1 <= s < 1/e                   the contact step: u' = [-a d + sqrt((1 + a) e^2 u^2 - a d^2)]/(1 + a), d' = d + u', so that
                                   u'^2 + a d'^2 = e^2 u^2
    s^2 + a < 1                    the contact goes on: u' = -[a d + sqrt(a^2 d^2 + (1 + a) u^2)]/(1 + a), d' = d + u'
    else                           it ends with this step: u' = -sqrt(u^2 + a d^2)

What the words fix: five cases; the overlap of the contact step is kept; below the line s = 1/e a contact is over in one step; the energy is
lost in the contact step alone; it serves a limited range of restitutions. Taken from the model of 2006: the later steps, in their mended form.
The root is real for e^2 s^2 >= a/(1 + a). Outside, which takes e < sqrt(a/(1 + a)), the step leaves the least energy it can, that of
a d^2/(1 + a) instead of e^2 u^2: more than asked. F = (u - u') meff/dt^2; nothing is shifted. A contact step may begin at s = 1/(1 + 1e-9).
Below p = u/scale, q = d/scale, whose squares are numbers for any u, d.

Source: reconstruction, after sections 1, 4 and 5.3 of S. Fujioka, S. Ushijima, "An evaluation method of normal contact force with energy
conservation in distinct element method" (2006), of the model that they published in Annual J. Hydraulic Engineering JSCE 49 (2005) 751.
Units: kn [force/length]; restitution 0 to 1, dimensionless. Not: the published algorithm of 2005, which was not at hand.
"""

from math import sqrt


def step(overlap: float, vn: float, meff: float, dt: float, kn: float, restitution: float) -> tuple[float, float, float]:
    """Mean force over the step, no correction of the overlap, energy taken."""
    u = -vn * dt
    scale = max(overlap, abs(u))
    if scale == 0.0:
        return 0.0, 0.0, 0.0
    a = kn * dt * dt / meff
    p, q = u / scale, overlap / scale
    end = sqrt(p * p + a * q * q)
    loss = 0.0
    if q <= restitution * p:
        after = -restitution * p
        loss = 0.5 * (1.0 - restitution * restitution) * meff * vn * vn
    elif q <= (1.0 + 1e-9) * p:
        left, least = restitution * p, sqrt(a / (1.0 + a)) * q
        after = (sqrt((1.0 + a) * max(left - least, 0.0) * (left + least)) - a * q) / (1.0 + a)
        left = max(left, least)
        loss = 0.5 * (p - left) * (p + left) * meff * (scale / dt) * (scale / dt)
    elif end < q:
        after = -(sqrt(a * a * q * q + (1.0 + a) * p * p) + a * q) / (1.0 + a)
    else:
        after = -end
    return (p - after) * scale * meff / (dt * dt), 0.0, loss


def energy(overlap: float, vn: float, meff: float, dt: float, kn: float, restitution: float) -> float:
    """kn d^2/2; at the contact step only the loss of that step, negative: it is booked already, while the velocity is still the old one."""
    u = -vn * dt
    if u > 0.0 and overlap <= (1.0 + 1e-9) * u:
        a = kn * dt * dt / meff
        left = max(restitution * u, sqrt(a / (1.0 + a)) * overlap)
        return -0.5 * (u - left) * (u + left) * meff / (dt * dt)
    return 0.5 * kn * overlap * overlap
