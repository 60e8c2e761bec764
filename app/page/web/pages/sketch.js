// Lets a hand or the arrow keys draw a prediction into a question's figure: heights at some columns, which a button sends.
() => {
  if (window.observerLabSketch) return;
  const drawn = window.observerLabSketch = {};  // of each question: the heights of its columns as shares of the frame, null where none is set
  const STEP = .05, KEYS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}, HALF = 13;
  const frame = element => element?.closest?.('.ol-sketch'), read = figure => JSON.parse(figure.dataset.sketch);
  const held = figure => drawn[read(figure).question] ??= {heights: read(figure).columns.map(() => null), at: 0};
  const clip = share => Math.min(Math.max(share, 0), 1);
  const filled = heights => heights.map((height, k) => {  // between two columns that are set a straight line, beyond them as at the nearest one
    if (height !== null) return height;
    const before = heights.findLastIndex((each, i) => i < k && each !== null), after = heights.findIndex((each, i) => i > k && each !== null);
    if (before < 0 || after < 0) return heights[Math.max(before, after)];
    return heights[before] + (heights[after] - heights[before]) * (k - before) / (after - before);
  });
  const show = figure => {
    const {columns, top, foot, bars} = read(figure), {heights, at} = held(figure), up = share => foot - share * (foot - top);
    const set = heights.flatMap((height, k) => height === null ? [] : [k]), send = figure.querySelector('button');
    const dot = k => `${columns[k].toFixed(1)} ${up(heights[k]).toFixed(1)}`;
    const path = bars ? set.map(k => `M${(columns[k] - HALF).toFixed(1)} ${up(heights[k]).toFixed(1)}h${2 * HALF}`).join('') : `M${set.map(dot).join('L')}`;
    figure.querySelector('.ol-sketched').setAttribute('d', set.length ? path : '');
    const caret = figure.querySelector('.ol-caret');
    caret.setAttribute('cx', columns[at]);
    caret.setAttribute('cy', up(heights[at] ?? .5));
    const ready = bars ? set.length === columns.length : set.length > 1 && columns[set.at(-1)] - columns[set[0]] >= .4 * (columns.at(-1) - columns[0]);
    send.disabled = !ready;
    const said = ready ? filled(heights).map(height => height.toFixed(3)).join(',') : '';
    send.dataset.value = said && `sketch:${said}`;  // for a page of one's own
    send.dataset.answer = said;  // for a class's vote
  };
  const follow = (svg, event, last) => {
    const figure = frame(svg), {columns, top, foot} = read(figure), sketch = held(figure), point = svg.createSVGPoint();
    Object.assign(point, {x: event.clientX, y: event.clientY});
    const {x, y} = point.matrixTransform(svg.getScreenCTM().inverse()), share = clip((foot - y) / (foot - top));
    const k = columns.reduce((best, each, i) => Math.abs(each - x) < Math.abs(columns[best] - x) ? i : best, 0);
    const from = last ? sketch.at : k, before = sketch.heights[from] ?? share;
    for (let i = from; ; i += Math.sign(k - from)) {  // a quick hand leaves out no column
      sketch.heights[i] = k === from ? share : before + (share - before) * (i - from) / (k - from);
      if (i === k) break;
    }
    sketch.at = k;
    show(figure);
  };
  const plane = event => frame(event.target) && event.target.closest('svg');
  let down = null, hand = null;  // the pointer that draws; the question that has the focus, also when its figure comes anew
  document.addEventListener('pointerdown', event => {
    const svg = plane(event);
    down = svg ? event.pointerId : null;
    if (!svg) return;
    svg.setPointerCapture(event.pointerId);
    svg.focus({preventScroll: true});
    follow(svg, event, false);
  });
  document.addEventListener('pointermove', event => {
    const svg = plane(event);
    if (!svg || event.pointerId !== down) return;
    if (!svg.hasPointerCapture(down)) svg.setPointerCapture(down);
    follow(svg, event, true);
  });
  for (const ends of ['pointerup', 'pointercancel']) document.addEventListener(ends, event => { if (event.pointerId === down) down = null; });
  document.addEventListener('focusin', event => { hand = plane(event) ? read(frame(event.target)).question : null; });
  document.addEventListener('keydown', event => {
    const svg = plane(event), turn = KEYS[event.key];
    if (!svg || !(turn || event.key === 'Enter')) return;
    event.preventDefault();
    event.stopPropagation();
    const figure = frame(svg), sketch = held(figure);
    if (!turn) return figure.querySelector('button:enabled')?.click();
    const k = Math.min(Math.max(sketch.at + turn[0], 0), sketch.heights.length - 1), height = sketch.heights[k] ?? sketch.heights[sketch.at] ?? .5;
    sketch.at = k;
    sketch.heights[k] = clip(height + turn[1] * STEP);
    show(figure);
  }, true);
  new MutationObserver(() => document.querySelectorAll('.ol-sketch').forEach(figure => {
    const {question} = read(figure);
    if (drawn[question] && !figure.querySelector('.ol-sketched').getAttribute('d')) show(figure);
    if (question === hand && document.activeElement === document.body) figure.querySelector('svg').focus({preventScroll: true});
  })).observe(document.body, {childList: true, subtree: true});
}
