"""The scene: materials, surfaces, cavity, drive, particles, and the effects that they require."""
