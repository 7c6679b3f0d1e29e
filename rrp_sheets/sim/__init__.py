"""The simulated world, which runs in a process of its own and is the only part that imports pybullet.

`process` starts that process, `server` is its program, and `world` holds everything together: robot (`body`, `stance`,
`gait`), scene (`stage`, `people`, `shapes`, `talk`), devices (`sensors`, `actuators`), record (`film`, `recording`).
"""
