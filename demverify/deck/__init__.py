"""Decks: text to commands with file and line, commands to a Setup, a Setup to a scene; and from one dialect to the other."""
