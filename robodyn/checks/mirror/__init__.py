"""Links that are each other's mirror image."""
