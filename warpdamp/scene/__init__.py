"""What is simulated: materials, surfaces, cavity, drive, particles, and the effects that they call for."""
