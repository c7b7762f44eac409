"""What holds for every array within the tolerances of a scene."""
