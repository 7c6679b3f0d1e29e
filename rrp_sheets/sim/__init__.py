"""The simulated world: the only part that imports pybullet and cv2. It runs in a process of its own."""
