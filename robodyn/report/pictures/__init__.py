"""Pictures of robots and links by their visual shapes."""
