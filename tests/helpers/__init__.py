"""What tests share: robots, motions, meshes and scenes, oracles, and runs of commands."""
