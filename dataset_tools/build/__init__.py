"""Many meshes to a data folder: resumable, on one machine or many."""
