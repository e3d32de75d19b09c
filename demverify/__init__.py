"""demverify: one deck, three engines, one verdict. See README.md; the command line is `demverify.cli`.

>>> import demverify
>>> demverify.erotate("post/dump*.liggghts", deck="in.run").rows[-1].erotate
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from demverify.analysis.erotate import erotate

__all__ = ["erotate"]


def __getattr__(name: str) -> Any:
    if name == "erotate":
        from demverify.analysis.erotate import erotate

        return erotate
    message = f"module 'demverify' has no attribute {name!r}"
    raise AttributeError(message)
