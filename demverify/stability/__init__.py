"""Stability: where a step of the solver breaks, against where theory says it does. The parts of `demverify stability`, listed in parts.py.

A part is a name and a function

    part(quick, progress) -> Finding, or a sequence of them (demverify.studies)

quick: a smaller run that shows the same; all parts together take under three minutes then. progress(what, share): what is being done, and the share
of the part that is done, 0 to 1. What a part claims is theory's; whatever goes wrong without having been announced is a claim that did not come out.

    limits*.py   the longest stable step: measured against predicted
    deck.py      the same for the scene of a deck
    stress*.py   scenes that are hard on any code, data in inputs/stress: who stays right, who says so, who does not
    held.py      scenes held in contact, and whether a disturbance of them grows
"""
