// Writes the names of up to four curves of a chart beside them, where they lie apart, in place of the key below it.
() => {
  if (window.observerLabNames) return;
  const viser = window.observerLabViser;
  const MOST = 4, COLUMNS = 72, REST = 250;  // ms without a new drawing before a name looks for a better place
  const ON = 60;  // trouble of a name on another

  // A colour #rrggbb with black or white in it, to read words in.
  const mixed = (colour, share, other) => `rgb(${[1, 3, 5].map(i => Math.round(share * parseInt(colour.slice(i, i + 2), 16) + (1 - share) * other))})`;

  // For each column of pixels what a curve fills of it, [top, bottom], null where it is not drawn.
  const fills = (chart, k, wide, high) => {
    const [xs, ys] = [chart.data[0], chart.data[k]], out = Array(COLUMNS).fill(null);
    for (let i = 0, last = null; i < xs.length; i += 1) {
      const y = ys[i] == null ? NaN : chart.valToPos(ys[i], 'y'), at = chart.valToPos(xs[i], 'x') / wide * COLUMNS;
      const column = Math.min(COLUMNS - 1, Math.max(0, Math.floor(at)));
      if (!Number.isFinite(y)) { last = null; continue; }
      for (let c = last ? Math.min(last.column + 1, column) : column; c <= column; c += 1) {
        const share = last && column > last.column ? (c - last.column) / (column - last.column) : 1, v = last ? last.y + share * (y - last.y) : y;
        const held = out[c] ??= [v, v];
        held[0] = Math.min(held[0], v); held[1] = Math.max(held[1], v);
      }
      last = {column, y};
    }
    return out.map(held => held && held[1] >= 0 && held[0] <= high ? held : null);
  };

  const best = (own, curves, room, size, taken) => {
    let found = null;
    for (let c = 1; c < COLUMNS - 1; c += 1) {
      if (!own[c]) continue;
      const x = (c + .5) * room.wide / COLUMNS, [top, bottom] = own[c];
      for (const [left, y, side] of [[x - size.wide / 2, top - size.high - 3, 'above'], [x - size.wide / 2, bottom + 3, 'below'],
        [x + 7, (top + bottom - size.high) / 2, 'right'], [x - 7 - size.wide, (top + bottom - size.high) / 2, 'left']]) {
        if (left < 2 || left + size.wide > room.wide - 2 || y < 1 || y + size.high > room.high - 1) continue;
        let trouble = .015 * Math.abs(c - .6 * COLUMNS);
        const from = Math.floor(left / room.wide * COLUMNS), to = Math.min(COLUMNS - 1, Math.floor((left + size.wide) / room.wide * COLUMNS));
        for (const curve of curves) for (let at = from; at <= to; at += 1) if (curve[at]) {
          const away = Math.max(curve[at][0] - y - size.high, y - curve[at][1]);  // below 0 where the curve runs through the name
          trouble += away < 0 ? (curve === own ? 3 : 6) : curve === own ? 0 : Math.max(0, 1 - away / 12);
        }
        const near = Math.min(...curves.filter(curve => curve !== own && curve[c]).map(curve =>
          Math.max(curve[c][0] - y - size.high, y - curve[c][1], 0)), 1e3);
        if (near < 10) trouble += 4;  // whose name would it be?
        for (const box of taken) if (left < box.right && box.left < left + size.wide && y < box.bottom && box.top < y + size.high) trouble += ON;
        if (!found || trouble < found.trouble) found = {trouble, left, y, side, column: c};
      }
    }
    return found;
  };

  const orders = list => (list.length < 2 ? [list] : list.flatMap((one, i) => orders(list.toSpliced(i, 1)).map(rest => [one, ...rest])));

  // A place for each name, one after the other; where a later one finds none that is free, the order with the least trouble.
  const arranged = (names, all, room) => {
    let found = null;
    for (const order of orders(names)) {
      const taken = [], spots = new Map();
      let trouble = 0;
      for (const name of order) {
        const spot = best(all[name.k], all.slice(1), room, name.size, taken);
        spots.set(name, spot);
        trouble += spot?.trouble ?? 2 * ON;
        if (spot) taken.push({left: spot.left - 2, right: spot.left + name.size.wide + 2, top: spot.y, bottom: spot.y + name.size.high});
      }
      if (!found || trouble < found.trouble) found = {trouble, spots};
      if (found.trouble < ON) break;
    }
    return found?.spots ?? new Map();
  };

  const place = chart => {
    const [wide, high] = [chart.over.clientWidth, chart.over.clientHeight], seen = new Set(), told = [];
    chart.series.forEach((series, k) => {
      if (k && series.label && series.show !== false && !seen.has(series.label)) { seen.add(series.label); told.push([series, k]); }
    });
    const few = told.length <= MOST && wide > 60 && high > 40;
    chart.root.classList.toggle('ol-named', few);
    const spans = chart.over.observerLabNames ??= new Map();
    for (const [label, span] of spans) if (!few || !seen.has(label)) { span.remove(); spans.delete(label); }
    if (!few) return;
    const all = chart.series.map((_, k) => k && fills(chart, k, wide, high));
    const names = told.map(([series, k]) => {
      let span = spans.get(series.label);
      if (!span) {
        span = document.createElement('span');
        span.className = 'ol-name';
        chart.over.append(span);
        spans.set(series.label, span);
      }
      span.hidden = false;
      span.textContent = series.label;
      const stroke = String(viser.strokeOf(chart, series));
      span.style.setProperty('--by-day', mixed(stroke, .66, 0));
      span.style.setProperty('--by-night', mixed(stroke, .4, 255));
      return {k, span, size: {wide: span.offsetWidth, high: span.offsetHeight}};
    });
    for (const [{k, span, size}, spot] of arranged(names, all, {wide, high})) {
      span.hidden = !spot;
      if (!spot) continue;
      span.observerLabSpot = {...spot, k, size};
      span.style.transform = `translate(${spot.left.toFixed(1)}px,${spot.y.toFixed(1)}px)`;
    }
  };

  const due = new WeakMap();
  const later = chart => {
    clearTimeout(due.get(chart));
    due.set(chart, setTimeout(() => { if (chart.root.isConnected) place(chart); }, REST));
  };
  const known = new WeakSet();
  const look = () => {
    for (const chart of viser.charts()) {
      if (known.has(chart)) continue;
      known.add(chart);
      viser.afterDrawing(chart, () => later(chart));
      place(chart);
    }
  };
  window.observerLabNames = new MutationObserver(() => requestAnimationFrame(look));
  window.observerLabNames.observe(document.body, {childList: true, subtree: true});
  look();
}
