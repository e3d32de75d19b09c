"""Parts of `demverify stability`: where the solver, and the engines beside it, break."""
