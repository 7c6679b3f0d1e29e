"""The simulated world, which runs in a process of its own and is the only part that imports pybullet and cv2.

`process` starts and controls that process and has its messages, `server` is its program, and `world` holds everything
together. `body`, `stance`, `gait` and `falling` are the robot; `keyframes` and `motion` move it. `stage` with `people`
and `shapes` is the scene; `portraits` and `face_traits` are its faces. `camera` and `vision` are the robot's sight,
`faces` with `face_memory` its recognition of persons, `talk` and `hearing` speech of people and its recognition.
`sensors` and `actuators` are the devices, `arbitration` decides between commands, and `tracker`, `voice`, `sounds` and
`colours` serve the actuators. `film` and `recording` are the record of the run.
"""
