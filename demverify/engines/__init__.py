"""Engines, found by listing this folder: a module that exposes `ENGINE` is one."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from demverify.engines.base import Engine


def _listing() -> dict[str, Engine]:
    modules = (import_module(f"{__name__}.{info.name}") for info in iter_modules(__path__) if info.name[0] != "_")
    return {module.ENGINE.name: module.ENGINE for module in modules if hasattr(module, "ENGINE")}


ENGINES: dict[str, Engine] = _listing()
