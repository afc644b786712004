"""What rules ask of a description beyond `robodyn.robot.urdf.view`: URDF's grammar and the tree of links."""
