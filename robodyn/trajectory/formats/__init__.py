"""Tables of every format, read a block of rows at a time: `table.py` says what each offers."""
