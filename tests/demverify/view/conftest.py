"""Calls of the command line, as in the tests of it."""

from tests.demverify.cli.conftest import demverify, write

__all__ = ["demverify", "write"]
