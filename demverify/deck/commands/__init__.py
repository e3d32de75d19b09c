"""The commands of a deck, a function each; `demverify.deck.command.handlers` imports every module here."""
