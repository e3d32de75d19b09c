"""Energy-conserving contact of Fujioka & Ushijima as printed: a map from overlap d and approach u (per step) to those of the next step.

With a = kn dt^2/meff and s = u/d, u' and d' the next approach and overlap, per pair with the reduced mass 1:

    s >= 1 (mode 1)                the contact step: the state is corrected to u^ = e s u/sqrt(s^2 + a), d^ = u^/s (15)-(17), then
                                   u' = [-a d^ + sqrt(a^2 d^^2 + (1 + a) u^^2)]/(1 + a), d' = d^ + u' (20), meant with d^
    0 < s < 1 (mode 2),
    -sqrt(1 - a) <= s <= 0 (mode 3)    u' = -[a d + sqrt(a^2 d^2 + (1 + a) u^2)]/(1 + a), d' = d + u' (21)
    else (mode 4)                  the contact ends with this step: u' = -sqrt(u^2 + a d^2) (23)

In mode 2 with s^2 + a > 1 the contact ends too, d' < 0, and the energy kn d'^2/2 is lost: a hole of the flow chart (figure 3), which
normal_fujioka2006 mends. Here that loss is booked as taken in the step. F = (u - u') meff/dt^2; shift = d - d^ makes the overlap smaller.
d <= 1e-9 u is left alone, p and q are u and d over a scale, as in normal_fujioka2006.

Source: S. Fujioka, S. Ushijima, "An evaluation method of normal contact force with energy conservation in distinct element method" (2006),
section 4, figure 3. Units: kn [force/length]; restitution 0 to 1, dimensionless.
Not: exact where a particle has several contacts, or other forces, at once.
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
    elif p > 0.0 or end < q:
        after = -(root + a * q) / (1.0 + a)
        beyond = min(q + after, 0.0) * scale
        loss = 0.5 * kn * beyond * beyond
    else:
        after = -end
    return (p - after) * scale * meff / (dt * dt), shift, loss


def energy(overlap: float, vn: float, meff: float, dt: float, kn: float, restitution: float) -> float:
    """kn d^2/2, less what the coming step takes: booked already, while the velocity is still the old one; at the contact step that alone."""
    u = -vn * dt
    if overlap <= 1e-9 * u:
        return 0.0
    if overlap <= (1.0 + 1e-9) * u:
        return -0.5 * (1.0 - restitution * restitution) * meff * vn * vn
    beyond = 0.0
    if u > 0.0:
        a, s = kn * dt * dt / meff, u / overlap
        beyond = min(overlap * (1.0 - sqrt(a * a + (1.0 + a) * s * s)) / (1.0 + a), 0.0)
    return 0.5 * kn * (overlap - beyond) * (overlap + beyond)
