"""The simulated world: the only part that imports pybullet and cv2. It runs in a process of its own.

`process` starts it and talks to it, `child` is that process, `world` holds everything together: `body` and `stance`
are the robot, `stage` with `figures` and `paths` the scene, `camera` and `vision` what the robot sees, `faces` whom it
knows, `signals` what people press, touch and say, `sensors` and `actuators` the devices, `arbitration` who may move
what and when a command is over, `tracker`, `voice` and `espeak` what they need, `film` and `strip` the
record of the run in pictures.
"""
