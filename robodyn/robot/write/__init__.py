"""Descriptions as text of a format, with what that format cannot say."""
