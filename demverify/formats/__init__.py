"""Files of engines and of ours: dumps, data files, logs, H5MD."""
