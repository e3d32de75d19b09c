"""Shapes of particles: volume and moments of inertia. One a file."""
