"""Forces at the points where a robot touches its surroundings: unilateral, inside cones of friction."""
