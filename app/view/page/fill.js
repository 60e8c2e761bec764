// In large print lets the figures of the column on the right fill it: a chart takes what those above it leave of a screenful, and a
// figure of which little more than its title would show begins the next one.
({large}) => {
  const lab = window.observerLabFill ??= {}, LEAST = .3, HALF = .5, TALLEST = 1.5, CLEAR = 6;  // shares; height over width; px
  lab.large = large;
  const column = () => document.querySelector('[data-dock-region=right]');

  const fill = () => {
    const captions = lab.large ? [...column()?.querySelectorAll('.ol-caption[data-figure]') ?? []].filter(each => each.checkVisibility()) : [];
    const room = captions[0]?.closest('[data-scrollarea-viewport]')?.clientHeight;
    if (!room) return;
    const charts = Object.values(window.__viserTestpoints?.uplots ?? {}).map(held => held.chart);
    const boxes = captions.map(caption => {
      const figure = caption.parentElement.previousElementSibling, look = getComputedStyle(caption);
      return {figure, chart: charts.find(chart => figure?.contains(chart.root)), high: figure?.offsetHeight ?? 0,
        words: caption.offsetHeight + parseFloat(look.marginTop) + parseFloat(look.marginBottom)};
    }).filter(box => box.high);
    let used = 0;
    for (const {figure, chart, high, words} of boxes) {
      const frame = chart ? high - chart.height : 0, rest = room - used;
      const needs = words + (chart ? LEAST * room + frame : high), anew = used > 0 && needs > rest;
      const apart = anew && rest > 0 && (chart || rest < HALF * high) ? `${Math.ceil(rest) + CLEAR}px` : '';
      if (figure.style.marginTop !== apart) figure.style.marginTop = apart;
      if (anew) used = 0;
      if (chart) {
        const height = Math.round(Math.min(Math.max(room - used - words - frame - CLEAR, LEAST * room), TALLEST * chart.width));
        if (Math.abs(height - chart.height) > 1) chart.setSize({width: chart.width, height});
        used += height + frame + words;
      } else used += high + words;
    }
  };
  lab.fill = fill;
  if (!lab.seen) {
    let due = 0;
    lab.later = () => { due ||= requestAnimationFrame(() => { due = 0; lab.fill(); }); };
    const sizes = new ResizeObserver(lab.later), known = new Set();
    const own = node => (node.nodeType === 1 ? node : node.parentElement)?.closest('[data-dock-region=right]') && !node.closest?.('.u-over');
    lab.seen = new MutationObserver(all => {
      for (const each of known) if (!each.isConnected) { known.delete(each); sizes.unobserve(each); }
      for (const view of column()?.querySelectorAll('[data-scrollarea-viewport]') ?? []) for (const each of [view, view.firstElementChild])
        if (each && !known.has(each)) { known.add(each); sizes.observe(each); }
      if (lab.large && all.some(({target}) => own(target))) lab.fill();
    });
    lab.seen.observe(document.body, {childList: true, subtree: true});
  }
  lab.later();
}
