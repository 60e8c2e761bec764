"""Light the stage and lay the plant's shadow on its floor."""

from __future__ import annotations

import viser

from ...colours import COLOURS, palette, rgb
from ..viser_private import page_scripts
from .floor import floor_ground, floor_lines, floor_shadow

KEY, GROUND, PICTURE = "/light/key", "/ground", "/shadow"
PLANT = "/plant"  # the node over the parts of the plant
SHADE = 0.2  # opacity of a cast shadow
METALS = ("steel", "metal")  # roles of colours


def light_up(scene: viser.SceneApi, dark: bool) -> None:
    """Floor and light of an empty stage, and a picture of a shadow: a machine without a graphics card has no other."""
    scene.configure_default_lights(False)
    scene.configure_environment_map(None)
    scene.add_light_hemisphere("/light/sky", sky_color=rgb(COLOURS["light-above"]), ground_color=rgb(COLOURS["light-below"]), intensity=2.1)
    scene.add_light_directional(KEY, color=rgb(COLOURS["light-key"]), intensity=2.3, position=(-4.0, -6.0, 9.0))
    scene.add_light_directional("/light/fill", color=rgb(COLOURS["light-fill"]), intensity=0.5, position=(6.0, -5.0, 4.0))
    scene.add_line_segments("/floor", floor_lines(), rgb(palette(dark)["floor"]), thickness=0.012)
    scene.add_mesh_simple(GROUND, *floor_ground(), color=(0, 0, 0), opacity=0.0, cast_shadow=False, receive_shadow=SHADE, visible=False,
                          position=(0.0, 0.0, 0.001))
    scene.add_image(PICTURE, floor_shadow(), 5.6, 3.4, format="png", cast_shadow=False, receive_shadow=False, position=(0.0, 0.1, 0.002))


def cast_shadows(client: viser.ClientHandle) -> None:
    """Let the page cast shadows and let metal reflect where a graphics card draws."""
    page_scripts.light_stage(client, KEY, GROUND, PICTURE, f"{PLANT}/", [rgb(COLOURS[role]) for role in METALS])
