"""How fast networks train and draw on the machine at hand: `python -m eval.throughput -o REPORT`."""
