"""What flies: the forces of rotors and air on a multirotor."""
