"""Shadows and reflections come where a card draws or where somebody asks for them, in every lesson; else nothing of them."""

from __future__ import annotations

from collections.abc import Callable

from tab import Tab, eventually

from observer_lab.lessons import LESSONS

LIT = """() => {
  const lab = window.observerLabViser, scene = lab.scene(), suns = [], floors = [], pictures = [];
  lab.node('/light/key')?.traverse(each => { if (each.isDirectionalLight) suns.push(each.castShadow); });
  lab.node('/ground')?.parent.traverse(each => { if (each.material?.isShadowMaterial) floors.push(each.visible && each.parent.visible); });
  lab.node('/shadow')?.traverse(each => { if (each.material?.map) pictures.push(each.visible); });
  const gloss = new Set();
  for (const [name, node] of lab.nodes()) if (name.startsWith('/plant/')) node?.traverse(each => {
    if (each.material?.isMeshStandardMaterial) gloss.add(each.material.roughness < 1);
  });
  return {cast: suns.some(Boolean), ground: floors.filter(Boolean).length, picture: pictures.some(Boolean),
          room: scene.environment !== null, gloss: [...gloss]};
}"""
FULL = {"cast": True, "ground": 1, "picture": False, "room": True, "gloss": [True]}
PLAIN = {"cast": False, "ground": 0, "picture": True, "room": False, "gloss": [False]}
ASKED = "localStorage.setItem('observer-lab-light', 'full')"
SLOW_CARD = """(() => {
  Object.defineProperty(window, 'observerLabNoCard', {get: () => false, set: () => {}});  // what draws is not known as a processor
  const pen = WebGL2RenderingContext.prototype, read = pen.readPixels;
  pen.readPixels = function (...how) {
    for (const end = performance.now() + 30; performance.now() < end;);
    return read.apply(this, how);
  };
})()"""


def opened(new_tab: Callable[..., Tab], before: str) -> Tab:
    """A tab whose page is loaded once more after a script has run."""
    tab = new_tab(own=True)
    tab.page.add_init_script(before)
    tab.page.reload()
    tab.settle()
    return tab


def lit(tab: Tab, wanted: dict[str, object], what: str) -> None:
    """Wait until the stage is lit so."""
    eventually(lambda: tab.page.evaluate(LIT), lambda seen: seen == wanted, what)


def test_without_a_card_a_picture_of_a_shadow_lies_under_the_plant(tab: Tab) -> None:
    eventually(lambda: tab.page.evaluate("window.observerLabLight?.full"), lambda full: full is False, "the light is decided")
    lit(tab, PLAIN, "the plain light")


def test_who_asks_for_shadows_has_them_in_every_lesson_until_they_turn_them_off(new_tab: Callable[..., Tab]) -> None:
    tab = opened(new_tab, ASKED)
    lit(tab, FULL, "shadows")
    words = LESSONS["saturation"].words["en"]
    tab.choose_lesson(words.title, words.question)
    lit(tab, FULL, "shadows in another lesson")
    tab.page.evaluate("window.observerLabLight.turn()")
    lit(tab, PLAIN, "the plain light")
    assert tab.page.evaluate("localStorage.getItem('observer-lab-light')") == "plain"


def test_a_card_that_is_too_slow_gets_the_plain_light(new_tab: Callable[..., Tab]) -> None:
    tab = opened(new_tab, SLOW_CARD)
    assert eventually(lambda: tab.page.evaluate("window.observerLabLight?.ms"), bool, "a timed frame") >= 30
    lit(tab, PLAIN, "the plain light")
    assert tab.page.evaluate("localStorage.getItem('observer-lab-light')") is None, "that is found anew at the next start"
