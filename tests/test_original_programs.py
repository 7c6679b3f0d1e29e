"""Five example programs of the original RRP software, as workbooks, give the outputs that it gave.

Where the original raised because of a bug of its own (a blob was a bare list, a face a number), ours works; those cases
say so. Its distances are in centimetres, by its own helper.
"""

from __future__ import annotations

import pytest
from play import example, play, rows

HELPERS = """
## Helpers
| Name | Inputs | Formula |
|---|---|---|
| Distance of | ball | (1 / 4) * (5 / tan(ball.width) + 5 / tan(ball.height)) |
| Brightness of | distance | 0 if distance > 20 else (20 - distance) / 15 if distance > 5 else 1 |
"""
DEVICES = """
## Devices
| Stream | Device | Mode | Colour | Text |
|---|---|---|---|---|
"""

BALL_TRACKING = rows(
    """
    | RedBall | sample | 500 | RedBallSampled |
    | RedBallSampled | map | Distance of | Distance |
    | Distance | filter | distance < 50 | Close |
    | Distance | filter | distance >= 50 | Far |
    | Close | subscribe | | TrackWithWholeBody |
    | Far | subscribe | | TrackWithHead |
    """,
    HELPERS,
    DEVICES + "| TrackWithWholeBody | Tracker | Whole body | | |\n| TrackWithHead | Tracker | Head | | |\n",
)
DISTANCE_TO_BRIGHTNESS = rows(
    """
    | RedBall | sample | 500 | Ball |
    | Ball | map | Distance of | Distance |
    | Distance | map | Brightness of | Brightness |
    | Brightness | subscribe | | EyeBrightness |
    """,
    HELPERS,
    DEVICES + "| RedBall | Blob | | #78131b | |\n",
)
MIRROR_BALL_COLORS = rows(
    """
    | green | map | [0, 1, 0] | greenMapped |
    | red | map | [1, 0, 0] | redMapped |
    | blue | map | [0, 0, 1] | blueMapped |
    | redMapped, blueMapped, greenMapped | merge | | colors |
    | colors | sample | 100 | colorsSampled |
    | colorsSampled | subscribe | | LedColor |
    """,
    DEVICES
    + "| green | Blob | | #2a9f35 | |\n| red | Blob | | #9a0f17 | |\n| blue | Blob | | #397ea9 | |\n"
    + "| LedColor | EyeLedColor | | | |\n",
)
SIMPLE_SAY_COLOR = rows(
    """
    | GreenBall | sample | 1000 | greenSampled |
    | RedBall | sample | 1000 | redSampled |
    | redSampled | subscribe | | SayRed |
    | greenSampled | subscribe | | SayGreen |
    | BlueBall | sample | 1000 | blueSampled |
    | blueSampled | subscribe | | SayBlue |
    """,
    DEVICES
    + "| RedBall | Blob | | #ff0000 | |\n| GreenBall | Blob | | #00ff00 | |\n| BlueBall | Blob | | #0000ff | |\n"
    + "| SayRed | SayParameter | | | red |\n| SayGreen | SayParameter | | | green |\n| SayBlue | SayParameter | | | blue |\n",
)
WELCOME_PEOPLE = rows(
    """
    | FaceDetection | sample | 10000 | FaceDetectionSampled |
    | FaceDetectionSampled | filter | not facedetectionsampled.new | KnownFaces |
    | KnownFaces | subscribe | | SayHelloAgain |
    | FaceDetectionSampled | filter | facedetectionsampled.new | NewFaces |
    | NewFaces | filter | newfaces.recognized_new_face | RecognizableFace |
    | NewFaces | subscribe | | SayHello |
    | RecognizableFace | subscribe | | RememberFace |
    """,
    DEVICES + "| SayHello | SayParameter | | | Hello |\n| SayHelloAgain | SayParameter | | | Hello again |\n",
)


def commands(book, stream, value, actuators):
    played = play(book, [(100, stream, value)], 11_000)
    assert not played.errors
    return {name: played.values(name) for name in actuators if played[name]}


@pytest.mark.parametrize(
    ("size", "expected"),
    [
        (0.2, {"TrackWithWholeBody": [12.332887188967232]}),
        (0.05, {"TrackWithWholeBody": [49.95832638723503]}),
        (0.04, {"TrackWithHead": [62.46666311056922]}),
    ],
)
def test_ball_tracking(size, expected):
    ball = example("RedBall", x=0.1, y=0.0, width=size, height=size)
    assert commands(BALL_TRACKING, "RedBall", ball, ["TrackWithWholeBody", "TrackWithHead"]) == expected


@pytest.mark.parametrize(("size", "expected"), [(0.05, 0), (0.2, 0.5111408540688511), (0.6, 1)])
def test_distance_to_brightness(size, expected):
    """The original's blob was a bare list without width, so it raised; ours is a record."""
    blob = example("Blob", x=0.1, y=0.0, width=size, height=size)
    assert commands(DISTANCE_TO_BRIGHTNESS, "RedBall", blob, ["EyeBrightness"]) == {"EyeBrightness": [expected]}


@pytest.mark.parametrize(("stream", "expected"), [("blue", [0, 0, 1]), ("green", [0, 1, 0]), ("red", [1, 0, 0])])
def test_mirror_ball_colors(stream, expected):
    blob = example("Blob", x=0.4, y=0.5, area=0.1)
    assert commands(MIRROR_BALL_COLORS, stream, blob, ["LedColor"]) == {"LedColor": [expected]}


@pytest.mark.parametrize("colour", ["Red", "Green", "Blue"])
def test_simple_say_color(colour):
    blob = example("Blob", x=0.4, y=0.5, area=0.1)
    said = commands(SIMPLE_SAY_COLOR, f"{colour}Ball", blob, ["SayRed", "SayGreen", "SayBlue"])
    assert said == {f"Say{colour}": [blob]}


@pytest.mark.parametrize(
    ("new", "clear", "expected"),
    [
        (True, False, ["SayHello"]),
        (True, True, ["SayHello", "RememberFace"]),
        (False, False, ["SayHelloAgain"]),
    ],
)
def test_welcome_people(new, clear, expected):
    """The original's face was a number without fields, so every event raised; ours is a record."""
    face = example("FaceDetection", new=new, recognized_new_face=clear)
    heard = commands(WELCOME_PEOPLE, "FaceDetection", face, ["SayHello", "SayHelloAgain", "RememberFace"])
    assert heard == {name: [face] for name in expected}
