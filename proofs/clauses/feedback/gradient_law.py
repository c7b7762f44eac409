"""The text of the law ``u = -k (a, b)`` (Jurdjevic and Quinn) by each form of V, under exact kinematics."""

from __future__ import annotations

from nonsmooth.proofs.clauses.feedback.control_lyapunov import SQUARES, ControlLyapunov

LAW = "u_i = -k a, u_j = -k b with b = (theta - c.J p_i)/(d_j.J(p_j - p_i)), a = c.d_i - (d_i.d_j) b"
WEIGHED_LAW = (
    "u_i = -k a, u_j = -k b with b = (l^2 theta - c.J p_i)/(d_j.J(p_j - p_i)), a = c.d_i - (d_i.d_j) b, l = {}"
)
SHAPED_LAW = (
    "u_i = -k a, u_j = -k b with b = (w theta - P c.J(p_i - c))/(d_j.J(p_j - p_i)), a = P c.d_i - (d_i.d_j) b, "
    "P = [[{}, {}], [{}, {}]], w = {}"
)


def gradient_text(lyapunov: ControlLyapunov) -> str:
    """The law ``u = -k (a, b)`` by V, under exact kinematics."""
    if lyapunov.length is not None:
        return LAW if lyapunov == SQUARES else WEIGHED_LAW.format(lyapunov.length)
    (e, f), w = lyapunov.shape, lyapunov.weight
    return SHAPED_LAW.format(1 + e, f, f, 1 - e, w)
