"""Perception of a robot, simulated or real, in the pictures of its camera and the sound of its microphone.

`vision` finds balls and spots of a colour, `faces` finds and recognises persons whom `face_memory` keeps, and
`word_recognition` recognises words. `pinhole` is the geometry of the camera. Nothing here knows a scene.
"""
