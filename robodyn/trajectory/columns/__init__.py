"""What the columns of a table mean: names, units and time. `resolve` in `layout.py` is the door."""
