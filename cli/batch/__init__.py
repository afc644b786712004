"""Many trajectories at a time: by processes of this machine, or by Dask."""
