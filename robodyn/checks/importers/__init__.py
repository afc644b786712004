"""What other programs make of a description: a table of what they do, and the programs themselves where installed."""
