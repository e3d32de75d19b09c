"""Spring, dashpot and slider against rolling, as LAMMPS' rolling sds computes it. With vl = reff (w - w_partner) x n:

    k |r.n| > 1e-10 mu |Fn|:  r is projected onto the tangent plane and stretched to its old length       (only when advance)
    r += dt vl                                                                                            (only when advance)
    f = -k r - gamma vl
    |f| > mu |Fn|:  f *= mu |Fn|/|f|,  r = -(f + gamma vl)/k (only when advance);  f = 0 where r = 0
    torque on the particle reff n x f, on the partner the opposite

k, gamma, mu: rolling_stiffness [force/length], rolling_damping [force time/length], rolling_friction. Energy k r^2/2; the dashpot and the slider
take energy. Not conserved, and so able to give: where gamma |vl| alone exceeds the limit, r is set against the motion with an energy that no work
has brought. r is of equal sign seen from either particle. Source: Y. Wang, F. Alonso-Marroquin, W. W. Guo, Particuology 23 (2015) 49,
doi:10.1016/j.partic.2015.02.002, eq. 31 for vl; S. Luding, Granular Matter 10 (2008) 235, doi:10.1007/s10035-008-0099-x; LAMMPS documentation,
pair_style granular, rolling sds. Not: at k = 0, where LAMMPS divides by zero, r is left alone.
"""

from math import sqrt

MEMORY = {"rolled_x": 1, "rolled_y": 1, "rolled_z": 1}


def torque(
    critical_force: float,
    reff: float,
    rolling_stiffness: float,
    rolling_damping: float,
    rolling_friction: float,
    nx: float,
    ny: float,
    nz: float,
    wx: float,
    wy: float,
    wz: float,
    rolled_x: float,
    rolled_y: float,
    rolled_z: float,
    dt: float,
    advance: bool,
) -> tuple[float, float, float, float, float, float]:
    """Rolling torque on the particle, and the new rolling displacement."""
    vx, vy, vz = reff * (wy * nz - wz * ny), reff * (wz * nx - wx * nz), reff * (wx * ny - wy * nx)
    rx, ry, rz = rolled_x, rolled_y, rolled_z
    limit = rolling_friction * critical_force
    if advance:
        along = rx * nx + ry * ny + rz * nz
        if abs(along) * rolling_stiffness > 1e-10 * limit:
            length = sqrt(rx * rx + ry * ry + rz * rz)
            rx, ry, rz = rx - along * nx, ry - along * ny, rz - along * nz
            projected = sqrt(rx * rx + ry * ry + rz * rz)
            stretch = length / projected if projected > 0.0 else 0.0
            rx, ry, rz = stretch * rx, stretch * ry, stretch * rz
        rx, ry, rz = rx + dt * vx, ry + dt * vy, rz + dt * vz
    k, gamma = rolling_stiffness, rolling_damping
    fx, fy, fz = -k * rx - gamma * vx, -k * ry - gamma * vy, -k * rz - gamma * vz
    size = sqrt(fx * fx + fy * fy + fz * fz)
    if size > limit:
        if rx == 0.0 and ry == 0.0 and rz == 0.0:
            return 0.0, 0.0, 0.0, rx, ry, rz
        cut = limit / size
        fx, fy, fz = cut * fx, cut * fy, cut * fz
        if advance and k > 0.0:
            rx, ry, rz = -(fx + gamma * vx) / k, -(fy + gamma * vy) / k, -(fz + gamma * vz) / k
    return reff * (ny * fz - nz * fy), reff * (nz * fx - nx * fz), reff * (nx * fy - ny * fx), rx, ry, rz


def energy(rolling_stiffness: float, rolled_x: float, rolled_y: float, rolled_z: float) -> float:
    """Energy of the spring, k r^2/2."""
    return 0.5 * rolling_stiffness * (rolled_x * rolled_x + rolled_y * rolled_y + rolled_z * rolled_z)
