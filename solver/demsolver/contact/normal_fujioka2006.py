"""Energy-conserving contact of Fujioka & Ushijima, mended: a map from overlap d and approach u (per step) to those of the next step.

With a = kn dt^2/meff and s = u/d, u' and d' the next approach and overlap, per pair with the reduced mass 1:

    s >= 1                         the contact step: the state is corrected to u^ = e s u/sqrt(s^2 + a), d^ = u^/s (15)-(17), then
                                   u' = [-a d^ + sqrt(a^2 d^^2 + (1 + a) u^^2)]/(1 + a), d' = d^ + u' (20), meant with d^
    s^2 + a < 1                    the contact goes on: u' = -[a d + sqrt(a^2 d^2 + (1 + a) u^2)]/(1 + a), d' = d + u' (21)
    else                           it ends with this step: u' = -sqrt(u^2 + a d^2) (23)

Each branch keeps u^2 + a d^2, but for the contact step, which leaves e^2 of it: the restitution of one contact is e to rounding at any step. The
published flow chart (normal_fujioka2006_printed) takes (21) for all 0 < s < 1, also where it ends the contact, and then loses a d'^2.
F = (u - u') meff/dt^2; shift = d - d^ makes the overlap smaller. Below p = u/scale, q = d/scale, whose squares are numbers for any u, d.

A sphere that touches no deeper than rounding, d <= 1e-9 u, is left alone: its contact begins with the next step, for which s may be as low as
1/(1 + 1e-9). Energy is kept all the same, and a scene that starts in exact touch does not take the contact step twice, or never.

Source: S. Fujioka, S. Ushijima, "An evaluation method of normal contact force with energy conservation in distinct element method" (2006),
section 4; the condition that mends it is that of (22). Units: kn [force/length]; restitution 0 to 1, dimensionless.
Not: exact where a particle has several contacts, or other forces, at once; not a force that has an energy of its own.
"""

from math import sqrt


def step(overlap: float, vn: float, meff: float, dt: float, kn: float, restitution: float) -> tuple[float, float, float]:
    """Mean force over the step, correction of the overlap, energy taken."""
    u = -vn * dt
    if overlap <= 1e-9 * u:
        return 0.0, 0.0, 0.0
    a = kn * dt * dt / meff
    scale = max(overlap, abs(u))
    p, q = u / scale, overlap / scale
    end, root = sqrt(p * p + a * q * q), sqrt(a * a * q * q + (1.0 + a) * p * p)
    shift = loss = 0.0
    if q <= (1.0 + 1e-9) * p:
        kept = restitution * p / end
        after = kept * (root - a * q) / (1.0 + a)
        shift = (1.0 - kept) * overlap
        loss = 0.5 * (1.0 - restitution * restitution) * meff * vn * vn
    elif end < q:
        after = -(root + a * q) / (1.0 + a)
    else:
        after = -end
    return (p - after) * scale * meff / (dt * dt), shift, loss


def energy(overlap: float, vn: float, meff: float, dt: float, kn: float, restitution: float) -> float:
    """kn d^2/2; at the contact step only the loss of that step, negative: it is booked already, while the velocity is still the old one."""
    u = -vn * dt
    if overlap <= 1e-9 * u:
        return 0.0
    if overlap <= (1.0 + 1e-9) * u:
        return -0.5 * (1.0 - restitution * restitution) * meff * vn * vn
    return 0.5 * kn * overlap * overlap
