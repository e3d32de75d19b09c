"""Spring of the DEM primer, whose length is kept and whose direction is that of today's sliding, with dashpot and Coulomb's bound:

    s = (|s| + |vt| dt) t,  t = vt/|vt|       (1.14), (1.15), only when advance;  where vt = 0 the spring stays as it was (1.16)
    Ft = -kt s - gt vt                        (1.11)
    |Ft| > mu |Fn|:  Ft = -mu |Fn| t (1.17), and the spring stays as it was (1.18)

vt is that of (1.12), which the kernel hands over. Source: K. Shobuzako, "DEM no kiso" (2025), 1.1.2 and 1.1.3.

The spring never unloads: its length grows with every bit of sliding, to or fro, and its force turns about at once where the sliding does.
So Ft.vt <= 0 whatever happens, nothing that it takes can be got back, and its energy counts as spent: `energy` is 0. That holds in continuous time.
In steps dt a contact that should stick trembles: vt changes sign each step while the spring grows by |vt| dt, so that force and tremble grow by the
factor lambda, the larger root of lambda^2 - (K + H) lambda - (1 - H) = 0, K = kt dt^2/m, H = gt dt/m, m the mass of the sliding motion: above one
for every step and every dashpot, about 1 + K/(2 - H). It ends at the bound, where each step turns vt round by mu |Fn| dt/m, and under a steady pull T
below the bound the contact does not rest but creeps with T dt/m: both of order dt, and in no other spring of this folder.
At vt = 0 over the bound, where (1.17) has no t, the force keeps the direction of the spring. Not: the spring of Cundall and Strack
(classic_history), nor that of LAMMPS' pair granular (rotated_history).
"""

from math import sqrt

MEMORY = {"sx": -1, "sy": -1, "sz": -1}


def force(
    critical_force: float,
    kt: float,
    gt: float,
    mu: float,
    vtx: float,
    vty: float,
    vtz: float,
    sx: float,
    sy: float,
    sz: float,
    dt: float,
    advance: bool,
) -> tuple[float, float, float, float, float, float]:
    """Tangential force on the particle, and the new spring vector."""
    length, speed = sqrt(sx * sx + sy * sy + sz * sz), sqrt(vtx * vtx + vty * vty + vtz * vtz)
    stretched = length + speed * dt if advance else length
    if speed > 0.0:
        tx, ty, tz = vtx / speed, vty / speed, vtz / speed
    elif length > 0.0:
        tx, ty, tz = sx / length, sy / length, sz / length
    else:
        return 0.0, 0.0, 0.0, sx, sy, sz
    size, limit = kt * stretched + gt * speed, mu * critical_force
    if size > limit:
        return -limit * tx, -limit * ty, -limit * tz, sx, sy, sz
    if advance:
        sx, sy, sz = stretched * tx, stretched * ty, stretched * tz
    return -size * tx, -size * ty, -size * tz, sx, sy, sz


def energy() -> float:
    """Nothing that can be got back."""
    return 0.0
