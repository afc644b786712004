"""The main job: what joints, bearings and motors carry along a motion, gathered block by block."""
