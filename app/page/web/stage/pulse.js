// The first time that a pointer comes over the stage, the discs that it can take hold of swell in colour, twice; where there are
// some whose name begins as told, which move most when they are dragged, those alone.
({ending, best, faint, full, lasts}) => {
  const viser = window.observerLabViser, canvas = viser.canvas();
  if (!canvas || window.observerLabPulse) return;
  window.observerLabPulse = 'waits';
  const discs = () => {
    const all = viser.nodes().filter(([name]) => name.endsWith(ending)), first = all.filter(([name]) => name.startsWith(best));
    return first.length ? first : all;
  };
  const skins = () => discs().flatMap(([, node]) => {
    const found = [];
    node?.traverse(part => { if (part.material) found.push(part.material); });
    return found;
  });
  const swell = begun => {
    const share = Math.min((performance.now() - begun) / lasts, 1);
    for (const skin of skins()) skin.opacity = faint + (full - faint) * Math.sin(2 * Math.PI * share) ** 2;
    viser.redraw();
    if (share < 1) requestAnimationFrame(() => swell(begun)); else window.observerLabPulse = 'told';
  };
  const near = () => {
    if (!skins().length) return;
    canvas.removeEventListener('pointermove', near);
    swell(performance.now());
  };
  canvas.addEventListener('pointermove', near);
}
