"""The simulated world, which runs in a process of its own and is the only part that imports pybullet.

`process` starts and controls that process and has its messages, `server` is its program, and `world` holds everything
together. `body`, `stance` and `gait` are the robot and its motions. `stage` with `people` and `shapes` is the scene;
`portraits` and `appearance` are its faces and colours. `camera` takes the robot's pictures, `talk` is the speech of
people and what the robot hears of it; `rrp_sheets.perception` finds out what is in both. `sensors` and `actuators` are
the devices, `arbitration` decides between commands, and `sounds` is what the robot lets be heard. `film` and
`recording` are the record of the run.
"""
