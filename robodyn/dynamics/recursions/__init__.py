"""Each recursion once, as a textbook writes it, over any scalar: RNEA, CRBA, ABA, momenta."""
