"""What the columns of a table mean: names, units and time; `layout.py` is the door."""
