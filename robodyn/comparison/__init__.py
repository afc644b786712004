"""Two descriptions of one robot: what differs, and what that does to the torques. The door is `compare`."""
