"""Scenes to look at: a run's particles in their shapes, coloured by rotational energy, as one page that needs nothing else."""
