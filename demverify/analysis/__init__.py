"""Post-processing of finished runs: from the frames of a dump to the rotational energy of what is in it."""
