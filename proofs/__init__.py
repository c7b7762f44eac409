"""The exact package again: inequality proofs, the clauses of Theorem 4, certificates, the stand-alone checker.

It may import `nonsmooth.symbolic` and `nonsmooth.analysis`: floats propose, exact arithmetic
disposes. It holds no tolerance, and missing evidence never passes.
"""

from typing import TYPE_CHECKING

from nonsmooth.symbolic.messages.notebook import on_demand

if TYPE_CHECKING:
    from nonsmooth.proofs.certificate import build_certificate as build_certificate
    from nonsmooth.proofs.certificate import certificate_text as certificate_text
    from nonsmooth.proofs.checker import check_file as check_file
    from nonsmooth.proofs.inequalities.prover import prove as prove
    from nonsmooth.proofs.system_audit import audit as audit
    from nonsmooth.proofs.system_decision import decide_system as decide_system
    from nonsmooth.proofs.theorem4 import CellCheck as CellCheck
    from nonsmooth.proofs.theorem4 import SmoothCheck as SmoothCheck
    from nonsmooth.proofs.theorem4 import check_theorem4 as check_theorem4

__getattr__ = on_demand(
    __name__,
    {
        "build_certificate": "certificate",
        "certificate_text": "certificate",
        "check_file": "checker",
        "prove": "inequalities.prover",
        "audit": "system_audit",
        "decide_system": "system_decision",
        "check_theorem4": "theorem4",
        "CellCheck": "theorem4",
        "SmoothCheck": "theorem4",
    },
)
