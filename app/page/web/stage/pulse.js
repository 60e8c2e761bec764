// The first time that a pointer comes over the stage, the discs that it can take hold of swell in colour, twice; where there are
// some whose name begins as told, which move most when they are dragged, those alone.
({ending, best, faint, full, lasts}) => {
  const page = window.__viserMutable;
  if (!page?.canvas || window.observerLabPulse) return;
  window.observerLabPulse = 'waits';
  const discs = () => {
    const all = Object.entries(page.nodeRefFromName).filter(([name]) => name.endsWith(ending)), first = all.filter(([name]) => name.startsWith(best));
    return first.length ? first : all;
  };
  const skins = () => discs().flatMap(([, held]) => {
    const found = [];
    (held && 'current' in held ? held.current : held)?.traverse(part => { if (part.material) found.push(part.material); });
    return found;
  });
  const swell = begun => {
    const share = Math.min((performance.now() - begun) / lasts, 1);
    for (const skin of skins()) skin.opacity = faint + (full - faint) * Math.sin(2 * Math.PI * share) ** 2;
    page.requestRender();
    if (share < 1) requestAnimationFrame(() => swell(begun)); else window.observerLabPulse = 'told';
  };
  const near = () => {
    if (!skins().length) return;
    page.canvas.removeEventListener('pointermove', near);
    swell(performance.now());
  };
  page.canvas.addEventListener('pointermove', near);
}
