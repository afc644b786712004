"""The dynamics of a robot as files of source code."""
