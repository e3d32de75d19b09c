"""The case that `demverify new-case` copies: decks and case.toml."""
