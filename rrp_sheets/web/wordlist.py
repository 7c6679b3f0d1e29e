"""Short words that are easy to say and to type, for passwords that the program makes: 256 of them, 8 bits each."""

from __future__ import annotations

_EASY = """
apple apron arrow autumn baker balloon bamboo banana barrel basket beach bean bear bell bench berry bicycle bird
blanket blue boat book bottle bowl branch bread breeze brick bridge broom brown brush bucket button cabin cactus
camel candle canoe carpet carrot castle cat cello chair chalk cherry chess circle clock cloud clover coat cocoa
coffee coin comet copper coral corn cotton cousin crayon cream cricket crown cup curtain daisy dance desert desk
dinner dolphin door dragon drawer drum duck eagle early earth easy echo eight elbow elephant engine evening
family farmer feather fern fiddle field finger fire fish five flag flower flute foam forest fork four fox
friend frog fruit garden garlic gate ginger giraffe glass globe glove goat gold grape grass green guitar hammer
happy harbor harvest hat hazel heart hedge helmet hill honey horse hotel house ice ink iron island ivory jacket
jam jasmine jelly jewel juice jungle kettle key kitchen kite kitten ladder lake lamp lantern laugh leaf lemon
letter light lily lime lion lizard lunch magnet mango maple marble market meadow melon metal milk mint mirror
monkey moon morning mountain mouse muffin music needle nest night nine noodle north oak ocean olive onion orange
orchard otter owl paddle paint panda paper parrot peach peanut pear pebble pencil penguin pepper piano picnic
pillow pilot pine planet plate pocket pond pony poppy potato pumpkin purple puzzle quiet rabbit radio rain
rainbow red ribbon rice river robin rocket rose ruby sail salad salt sand silver sister six sky snow soap sofa
soup spoon spring star
"""


def easy_words() -> list[str]:
    """All of them.

    >>> len(set(easy_words()))
    256
    """
    return _EASY.split()
