"""The simulated world: the only part that imports pybullet and cv2. It runs in a process of its own.

`process` starts it and talks to it, `child` is that process, `world` holds everything together: `body` and `stance`
are the robot, `stage` with `figures`, `people`, `heads` and `paths` the scene (`face_people` and `face_drawing` make
the faces, `portraits` pictures of them), `camera` and `vision` what the robot sees, `faces` with `face_models` and
`face_memory` whom it finds and knows, `signals` what people press, touch and say, `sensors` and `actuators` the
devices, `arbitration` who may move what and when a command is over, `tracker`, `voice` and `espeak` what they need,
`film` and `strip` the record of the run in pictures.
"""
