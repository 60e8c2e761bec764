// Plays a recorded run on a page without a server: what stands on the stage, the clock, the cursors of the figures beside it.
({run, words}) => {
  const viser = window.observerLabViser, calm = matchMedia('(prefers-reduced-motion: reduce)').matches, find = name => document.querySelector(name);
  const [button, start, view, time, speed, clock] = ['play', 'start', 'view', 'time', 'speed', 'clock'].map(name => find(`.ol-replay-${name}`));
  const LETTERS = 11;  // px of letters on the stage
  let shape = 0;
  const place = (marks, value) => {  // of the last mark that is not above a value
    let low = 0, high = marks.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (marks[middle] <= value) low = middle; else high = middle - 1;
    }
    return low;
  };
  const message = ({name, prop, floats}, value) => viser.moved(run.owner, name, prop, floats ? new Float32Array(value) : value);
  const turn = (channels, step) => {
    const messages = channels.flatMap(channel => {
      const k = place(channel.at, step);
      if (k === (channel.shown ?? 0)) return [];
      channel.shown = k;
      return [message(channel, channel.to[k])];
    });
    if (messages.length) viser.show(messages);
  };
  const show = now => {
    turn(run.moves, place(run.t, now + 1e-9));
    document.querySelectorAll('.ol-replay-now').forEach(line => {
      const {from, to} = line.dataset, share = (now - from) / (to - from);
      line.hidden = share < 0 || share > 1;
      line.style.setProperty('--ol-t', share);
    });
    time.value = now;
    clock.textContent = `t = ${now.toFixed(run.digits)} s`;
    time.setAttribute('aria-valuetext', clock.textContent);
    button.textContent = player.playing ? words.pause : words.play;
  };
  const player = viser.runner(show, () => run.end, () => run.rate * speed.value);
  const go = (wanted, from = player.now) => {
    player.now = wanted && from >= run.end - 1e-9 ? run.t[0] : from;
    player.go(wanted);
    show(player.now);
  };
  const look = () => {
    const {clientWidth: wide, clientHeight: high} = viser.canvas(), [x, y, z, ...aim] = run.eye;
    if (!wide || !high) return;
    shape = wide / high;
    const [from, back] = viser.farther([x, y, z], aim, run.narrow);
    viser.lookFrom(from, aim, run.sight);
    const em = LETTERS / high * 2 * Math.tan(run.sight / 2) * (run.near * back + run.behind);
    turn(run.letters, place(run.sizes, em * 1.06));
  };
  button.addEventListener('click', () => go(!player.playing));
  start.addEventListener('click', () => go(false, run.t[0]));
  view.addEventListener('click', look);
  time.addEventListener('input', () => go(false, Number(time.value)));
  addEventListener('keydown', event => {
    if (event.code !== 'Space' || event.target.closest?.('button,select,summary,a')) return;
    event.preventDefault();
    go(!player.playing);
  });
  requestAnimationFrame(() => {
    find('.ol-replay-wait').hidden = true;
    const canvas = viser.canvas();
    new ResizeObserver(() => { if (Math.abs(canvas.clientWidth / canvas.clientHeight - shape) > .03 * shape) look(); }).observe(canvas);
    look();
    go(!calm, run.t[0]);
  });
}
