"""What connects a robot's devices to the streams of a run."""
