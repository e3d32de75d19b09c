"""demverify: one deck, three engines, one verdict. See README.md; the command line is `demverify.cli`."""
