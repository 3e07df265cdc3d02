# SPDX-License-Identifier: GPL-3.0-or-later
"""The colours of all pages and figures, in three schemes.

Colours of lines have the hues of Okabe and Ito (2008), which colour-blind readers can distinguish.
"""

_NAMES = ("paper", "card", "ink", "faint", "rule", "link", "good", "bad", "middle", "force",
          "pick", *(f"line{i}" for i in range(1, 9)))  # fmt: skip
_LIGHT = ("#ffffff #f6f7f9 #1d2126 #5c6673 #dde1e7 #00609c #1b7f4b #b3261e #8a5a00 #c22316 "
          "#d81b60 #0072b2 #d55e00 #009e73 #cc79a7 #b58900 #7a58b0 #4a90a4 #a05a2c")  # fmt: skip
_DARK = ("#14171b #1d2127 #e7eaee #97a1af #333a44 #6cb8f0 #59c98c #ff8a80 #e8b44c #ff6f61 "
         "#ff5c9d #5ab4f0 #ff9a4d #4fd1a5 #f0a6cf #e6c34a #b79df0 #7fd0e0 #d9a07a")  # fmt: skip
SCHEMES = {name: dict(zip(_NAMES, colors.split(), strict=True))
           for name, colors in (("light", _LIGHT), ("dark", _DARK))}  # fmt: skip
SCHEMES["print"] = SCHEMES["light"] | {"card": "#ffffff", "ink": "#000000", "faint": "#404040",
                                       "rule": "#bbbbbb"}  # fmt: skip
PAPER, _, INK, FAINT, RULE = _LIGHT.split()[:5]
FORCE, POINT = (SCHEMES["light"][name] for name in ("force", "pick"))
COLORS = tuple(SCHEMES["light"][f"line{i}"] for i in range(1, 9))
BLUE, ORANGE, GREEN, PINK, GOLD, PURPLE = COLORS[:6]
RED, GREY = FORCE, FAINT
STONES = ("#dccfb4", "#b4c4d4", "#d3b09a", "#bccbaa", "#c9bad6", "#e6d88f", "#a9adb3", "#9fcac2")
COMPRESSION, TENSION = "#111111", "#ff2d2d"  # colour of principal stresses, visible on all blocks
STONE, GROUND, FIELD = STONES[0], STONES[6], GOLD
EDGE = "#22262b"  # colour of block edges; in all schemes, because faces do not depend on them
RESTING = "#c3c8ce"  # colour of blocks whose value is a rounding error
BOLT, WATER = PURPLE, "#2f7fb8"
JOINTS = ("#4a4f57", BLUE, ORANGE, GREEN, PINK, GOLD)
MAGNITUDE, SIGNED = "viridis", "PuOr"


def css_variables() -> str:
    """Return the colours of all schemes as CSS variables for light, dark and print."""
    sheets = {
        name: "".join(f"--{key}: {color}; " for key, color in scheme.items())
        for name, scheme in SCHEMES.items()
    }
    return (
        f":root {{ {sheets['light']}}}\n"
        f"@media screen and (prefers-color-scheme: dark) {{ :root {{ {sheets['dark']}}} }}\n"
        f"@media print {{ :root {{ {sheets['print']}}} }}\n"
    )
