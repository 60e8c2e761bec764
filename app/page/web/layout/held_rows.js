// While a hand holds a slider or the stage, nothing of the column moves under it: each row keeps its height, and a new one waits until
// the hand lets go. Then the column takes the room that it needs.
() => {
  if (window.observerLabHeldRows) return;
  const viser = window.observerLabViser, ROWS = 'data-stays', SILENT = 'data-silent', WAITS = 'data-waits';
  let held = [], inside = [];
  const free = () => {
    for (const row of held) {
      for (const name of [ROWS, SILENT]) row.removeAttribute(name);
      for (const name of ['--ol-high', '--ol-answer']) row.style.removeProperty(name);
    }
    for (const room of inside) room.removeAttribute(WAITS);
    [held, inside] = [[], []];
  };
  const hold = room => {
    if (inside.includes(room)) return;
    inside.push(room);
    for (const row of room.children) held.push(row);
  };
  const down = ({target}) => {
    free();
    const view = [...document.querySelectorAll(`${viser.parts.column} ${viser.parts.view}`)].find(each => each.checkVisibility());
    const slider = target?.closest?.(viser.parts.slider), stage = target?.matches?.(viser.parts.stage);
    if (!view || !(slider || stage)) return;
    const from = slider && view.contains(slider) ? slider.closest(viser.parts.row) : view.querySelector('.ol-card,.ol-head');
    for (let each = from; each && each !== view; each = each.parentElement) hold(each.parentElement);
    const high = element => `${element?.getBoundingClientRect().height ?? 0}px`;
    const heights = held.map(row => [high(row), high(row.querySelector('.ol-answer'))]);  // all read before one is written
    held.forEach((row, k) => {
      row.style.setProperty('--ol-high', heights[k][0]);
      row.style.setProperty('--ol-answer', heights[k][1]);
      row.toggleAttribute(SILENT, heights[k][1] === '0px');
      row.setAttribute(ROWS, row.querySelector(viser.parts.slider) ? 'open' : '');
    });
    for (const room of inside) room.setAttribute(WAITS, '');
  };
  window.observerLabHeldRows = {free};
  addEventListener('pointerdown', down, {capture: true, passive: true});
  for (const end of ['pointerup', 'pointercancel', 'blur']) addEventListener(end, free, {capture: true, passive: true});
}
