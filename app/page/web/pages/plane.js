// Lets a hand or the arrow keys place a pole on the plane of an open vote; what is placed stays there when the page is written anew.
() => {
  if (window.observerLabPlane) return;
  const placed = window.observerLabPlane = {};
  const MINUS = '\u2212', KEYS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
  const frame = element => element?.closest?.('.ol-place');
  const read = figure => JSON.parse(figure.dataset.plane);
  const number = value => String(Number(value.toPrecision(4))).replace('-', MINUS);
  const show = figure => {
    const pole = placed[figure.dataset.vote], plane = read(figure);
    if (!pole) return;
    for (const cross of figure.querySelectorAll('.ol-cross')) {
      const x = (pole.re - plane.low) / (plane.high - plane.low) * plane.width;
      const y = (1 - Number(cross.dataset.sign) * pole.im / plane.top) / 2 * plane.height;
      cross.setAttribute('transform', `translate(${x},${y})`);
      cross.setAttribute('visibility', cross.dataset.sign === '1' || pole.im ? 'visible' : 'hidden');
    }
    figure.querySelector('output').textContent = number(pole.re) + (pole.im ? ` \u00b1 ${number(pole.im)}j` : '');
    const send = figure.querySelector('button');
    send.disabled = false;
    send.dataset.answer = `${pole.re}:${pole.im}`;
  };
  const place = (figure, re, im) => {
    const {low, high, top, step} = read(figure);
    const on = (value, least, most) => {
      const cell = Math.min(Math.max(Math.round(value / step), Math.ceil(least / step - 1e-9)), Math.floor(most / step + 1e-9));
      return Number((cell * step).toPrecision(9)) + 0;
    };
    placed[figure.dataset.vote] = {re: on(re, low, high), im: on(Math.abs(im), 0, top)};
    show(figure);
  };
  const follow = (svg, event) => {
    const {low, high, top, width, height} = read(frame(svg)), at = svg.createSVGPoint();
    Object.assign(at, {x: event.clientX, y: event.clientY});
    const {x, y} = at.matrixTransform(svg.getScreenCTM().inverse());
    place(frame(svg), low + x / width * (high - low), (1 - 2 * y / height) * top);
  };
  const plane = event => frame(event.target) && event.target.closest('svg');
  document.addEventListener('pointerdown', event => {
    const svg = plane(event);
    if (!svg) return;
    svg.setPointerCapture(event.pointerId);
    svg.focus();
    follow(svg, event);
  });
  document.addEventListener('pointermove', event => {
    const svg = plane(event);
    if (svg?.hasPointerCapture(event.pointerId)) follow(svg, event);
  });
  document.addEventListener('keydown', event => {
    const svg = plane(event), turn = KEYS[event.key];
    if (!svg || !(turn || event.key === 'Enter')) return;
    event.preventDefault();
    event.stopPropagation();
    const figure = frame(svg), {low, high, step} = read(figure), pole = placed[figure.dataset.vote] ?? {re: (low + high) / 2, im: 0};
    if (!turn) figure.querySelector('button:enabled')?.click();
    else place(figure, pole.re + turn[0] * step * (event.shiftKey ? 5 : 1), Math.max(pole.im + turn[1] * step * (event.shiftKey ? 5 : 1), 0));
  }, true);
  new MutationObserver(() => document.querySelectorAll('.ol-place').forEach(figure => {
    if (placed[figure.dataset.vote] && !figure.querySelector('button').dataset.answer) show(figure);
  })).observe(document.body, {childList: true, subtree: true});
}
