"""Where things of the 3-D stage are on the screen, as the browser itself has placed them."""

from __future__ import annotations

from collections.abc import Callable

from tab import Tab

WHERE = """name => {
  const page = window.__viserMutable, held = page.nodeRefFromName[name];
  const node = held && 'current' in held ? held.current : held;
  if (!node) return null;
  node.updateWorldMatrix(true, false);
  const at = node.position.clone().setFromMatrixPosition(node.matrixWorld).project(page.camera);
  const box = page.canvas.getBoundingClientRect();
  return [box.x + (at.x + 1) / 2 * box.width, box.y + (1 - at.y) / 2 * box.height];
}"""
LOCAL = """name => {
  const held = window.__viserMutable.nodeRefFromName[name];
  const node = held && 'current' in held ? held.current : held;
  return node ? node.position.toArray() : null;
}"""


def on_screen(tab: Tab, node: str) -> tuple[float, float]:
    """The pixel at which a scene node's origin is drawn."""
    at = tab.page.evaluate(WHERE, node)
    assert at is not None, f"there is no node {node} in the scene"
    return at[0], at[1]


def on_board(tab: Tab, board: str, pole: int) -> tuple[float, float]:
    """Where a pole's cross stands on its board: to the right, and up."""
    at = tab.page.evaluate(LOCAL, f"/board/{board}/pole{pole}")
    assert at is not None, f"board {board} has no pole {pole}"
    return at[0], at[2]


def drag(tab: Tab, start: tuple[float, float], by: tuple[float, float], steps: int = 6, look: Callable[[], object] | None = None) -> None:
    """Press at a pixel, move by pixels, release, as a hand would; what it came to is then shown.

    `look` is called once the first step is made: what is said only for some seconds is read then.
    """
    mouse = tab.page.mouse
    mouse.move(*start)
    tab.answered()
    mouse.down()
    tab.answered()
    for i in range(1, steps + 1):
        mouse.move(start[0] + by[0] * i / steps, start[1] + by[1] * i / steps)
        tab.answered()
        if look is not None and i == 1:
            look()
    mouse.up()
    tab.answered(rests=True)
