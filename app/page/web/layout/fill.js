// In large print lets the figures of the column on the right fill it: a chart takes what those above it leave of a screenful, and a
// figure of which little more than its title would show begins the next one. Where that would leave much of one empty, the chart
// fills it and its words alone are on the next. In usual print charts grow by equal parts into what their tab would leave empty.
({large}) => {
  const viser = window.observerLabViser, {chart: CHART, column: COLUMN, view: VIEW} = viser.parts;
  const lab = window.observerLabFill ??= {}, LEAST = .3, MUCH = .35, HALF = .5, SMALL = .24, LOW = .4, TALLEST = 1.5;  // shares; height over width
  const CLEAR = 6, SHEET = 896, ASKED = 160, AIR = .7;  // px; px of the widest window with a sheet; px that a question's figure has at least; letters
  const DRAWN = `${CHART},.ol-table,.ol-figure,:has(${CHART},.ol-table,.ol-figure)`;
  const [SPARE, SLACK] = [26, 66];  // px left below grown charts, so that a caption may take a line more; px from which they grow again
  lab.large = large;
  lab.heights ??= new WeakMap();  // of charts in usual print: as the lab made them, and as `share` left them
  const column = () => document.querySelector(COLUMN), rect = each => each.getBoundingClientRect();

  // Where the figures leave some of the column and no chart can take it, the rows of tables stand farther apart.
  const airy = (view, last, room) => {  // `room` without what stands below the last words
    const tables = [...view.querySelectorAll('.ol-table')].map(each => [each, each.rows.length, parseFloat(each.style.getPropertyValue('--air')) || 0]);
    const rows = tables.reduce((sum, [, count]) => sum + count, 0);
    if (!rows) return;
    const close = rect(last).bottom - rect(view.firstElementChild).top - 2 * tables.reduce((sum, [, count, air]) => sum + count * air, 0);
    const most = AIR * parseFloat(getComputedStyle(tables[0][0]).fontSize), air = Math.floor(Math.max(0, Math.min((room - close - 2 * CLEAR) / (2 * rows), most)));
    for (const [each, , has] of tables) if (has !== air) each.style.setProperty('--air', `${air}px`);
  };

  // In usual print; only beside a card is a chart lower than it was made, so that the scene is seen whole. None grows while it would have
  // to shrink again for a longer caption.
  const share = (view, captions, room, charts) => {
    const carded = innerWidth > SHEET && view.querySelector('.ol-card');
    const own = charts.filter(each => view.contains(each.root)), top = rect(view.firstElementChild).top;
    const left = room - rect(captions.at(-1)).bottom + top, sizes = own.map(chart => {
      const held = lab.heights.get(chart), made = held?.now === chart.height ? held.made : chart.height;
      return {chart, made, least: carded ? Math.round(LOW * made) : made, most: Math.max(made, Math.round(TALLEST * chart.width))};
    });
    if (!own.length && captions.length === 1 && carded) {
      const drawn = captions[0].parentElement.previousElementSibling?.querySelector('.ol-figure>svg');
      if (drawn) shrink(view, drawn, room - rect(captions[0]).bottom + rect(drawn).bottom - CLEAR);
    }
    if (!own.length) airy(view, captions.at(-1), room - SPARE);
    if (!own.length || (left >= 0 && left <= SLACK)) return;
    const usual = sizes.reduce((sum, {chart, made}) => sum + chart.height - made, 0), more = Math.floor((left + usual - SPARE) / own.length);
    for (const {chart, made, least, most} of sizes) {
      const height = Math.min(Math.max(made + more, least), most);
      lab.heights.set(chart, {made, now: height});
      if (height !== chart.height) chart.setSize({width: chart.width, height});
    }
  };

  // The figure of a question takes what the card leaves of the column, so that the verdict and it are seen together.
  const fit = () => {
    const drawn = column()?.querySelector('.ol-figure[data-figure=question]>svg'), view = drawn?.closest(VIEW);
    if (!view?.clientHeight) return;
    const below = drawn.closest('.ol-sketch')?.lastElementChild.offsetHeight ?? 0;  // the words and the button under it
    const left = `${Math.round(Math.max(ASKED, view.clientHeight - (rect(drawn).top - rect(view.firstElementChild).top) - below - 2 * CLEAR))}px`;
    if (drawn.style.maxHeight !== left) drawn.style.maxHeight = left;
  };

  // The first map of a column in large print, and a lone drawing of a scene, is as high as the card leaves it, so that it is seen whole.
  const shrink = (view, drawn, room) => {
    if (!drawn) return;
    const left = `${Math.round(Math.max(SMALL * view.clientHeight, room - (rect(drawn).top - rect(view.firstElementChild).top) - CLEAR))}px`;
    if (drawn.style.maxHeight !== left) drawn.style.maxHeight = left;
  };

  const fill = () => {
    fit();
    const all = [...column()?.querySelectorAll('.ol-caption[data-figure]') ?? []];
    const captions = all.filter(each => each.checkVisibility());
    const view = captions[0]?.closest(VIEW), room = view?.clientHeight;
    if (!room) return;
    const charts = viser.charts();
    if (!lab.large) return share(view, captions, room, charts);
    const gap = parseFloat(getComputedStyle(captions[0]).marginBottom) || 0;
    let page = 0, before = null, late = 0;  // where the screenful begins, as it is scrolled to; px that charts are yet to grow
    for (const caption of captions) {
      const figure = caption.parentElement.previousElementSibling, chart = charts.find(each => figure?.contains(each.root));
      if (!figure?.offsetHeight) continue;
      if (!chart && !before) shrink(view, figure.querySelector('.ol-figure:not([data-figure=question])>svg'), room - rect(caption).bottom + rect(figure).bottom);
      const high = figure.offsetHeight, frame = chart ? high - chart.height : 0, says = rect(caption).bottom - rect(figure).bottom;
      const rest = before ? page + room - rect(before).bottom - late - gap : room;
      const least = chart ? LEAST * room + frame : high, whole = least + says <= rest;
      const bare = before && chart && !whole && rest > MUCH * room && least + CLEAR <= rest;  // its words begin the next screenful
      const anew = before && !whole && !bare;
      const apart = anew && rest > 0 && (chart || rest < HALF * high) ? `${Math.ceil(rest + gap) + CLEAR}px` : '';
      if (figure.style.marginTop !== apart) figure.style.marginTop = apart;
      const top = rect(figure).top + late;
      const above = before ? 0 : top - rect(view.firstElementChild).top;  // of the first figure, as long as nothing is scrolled
      if (anew || !before) page = top;
      if (chart) {
        const left = room - above - (top - page) - frame - (bare ? 0 : says) - CLEAR;
        const height = Math.round(Math.min(Math.max(left, LEAST * room), TALLEST * chart.width)), more = height - chart.height;
        if (Math.abs(more) > 1) {
          late += more;
          chart.setSize({width: chart.width, height});
        }
      }
      before = caption;
    }
    if (!view.querySelector(CHART)) airy(view, captions.at(-1), room - gap);
    const wanted = captions.findIndex(each => each.parentElement === lab.wanted);
    if (wanted >= 0) {
      const at = wanted && rect(lab.wanted.previousElementSibling).top - rect(view.firstElementChild).top;
      if (Math.abs(view.scrollTop - at) > 1) view.scrollTop = at;
    }
  };
  lab.fill = fill;
  if (!lab.seen) {
    let due = 0;
    lab.later = () => { due ||= requestAnimationFrame(() => { due = 0; lab.fill(); }); };
    const sizes = new ResizeObserver(lab.later), known = new Set();
    const own = node => (node.nodeType === 1 ? node : node.parentElement)?.closest(COLUMN) && !node.closest?.(viser.parts.plot);
    lab.seen = new MutationObserver(all => {
      for (const each of known) if (!each.isConnected) { known.delete(each); sizes.unobserve(each); }
      for (const view of column()?.querySelectorAll(VIEW) ?? []) for (const each of [view, view.firstElementChild])
        if (each && !known.has(each)) { known.add(each); sizes.observe(each); }
      if (all.some(({target, addedNodes}) => (lab.large || [...addedNodes].some(node => node.matches?.(DRAWN))) && own(target))) lab.fill();
    });
    lab.seen.observe(document.body, {childList: true, subtree: true});
    // Figures that are still being drawn would draw a column that snaps along with them: it snaps once a hand is at it. Until then
    // the figure that the lab has opened, `lab.wanted` by what bears its words, stands at the top.
    for (const kind of ['wheel', 'touchstart', 'pointerdown', 'keydown']) document.addEventListener(kind, ({target}) => {
      if (!target.closest?.(COLUMN)) return;
      lab.wanted = null;
      if (target.closest('[role=tablist]')) return;
      for (const view of column().querySelectorAll(VIEW)) if (view.checkVisibility()) view.dataset.slid = '';
    }, {capture: true, passive: true});
  }
  lab.later();
}
