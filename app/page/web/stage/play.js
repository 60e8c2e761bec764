// Plays poses that came ahead of their time: gives them to viser when they are due, as if they came from the server just then.
({widget, stop, begins, every, owner, names, times, told, moves}) => {
  const viser = window.observerLabViser, KINDS = ['position', 'wxyz', 'scale', 'color', 'points', 'text'], FINE = 1e5, SLIDE = 3;
  const player = window.observerLabPlayer ??= {queue: [], wake: 0, count: 0};
  if (widget) {
    viser.tell(widget, 1);
    return;
  }
  if (stop || begins) player.queue.length = 0;
  if (stop) return;
  const now = performance.now();
  const first = begins || !(player.last > now - every) ? now : player.last + every;  // a late message holds the last pose
  JSON.parse(moves).forEach((move, k) => player.queue.push({due: first + k * every, move, t: times[k]}));
  player.last = first + (times.length - 1) * every;
  const message = (name, kind, value) => viser.moved(owner, name, kind, kind === 'points' ? new Float32Array(value)
    : kind === 'text' ? String.fromCodePoint(...value) : value);
  const read = (move, found) => {
    for (let i = 0; i < move.length;) {
      const name = names[move[i]], kind = KINDS[move[i + 1]], many = move[i + 2], fine = kind === 'color' || kind === 'text' ? 1 : FINE;
      found.set(`${name} ${kind}`, [name, kind, move.slice(i + 3, i + 3 + many).map(number => number / fine)]);
      i += 3 + many;
    }
  };
  player.show = frames => {  // one or, where frames of the browser are slow, several that have come due
    const found = new Map(), {t} = frames[frames.length - 1];
    frames.forEach(({move}) => read(move, found));
    const messages = [...found.values()].map(each => message(...each));
    viser.show([...messages, ...viser.told(told, t, ++player.count % SLIDE === 0 || t >= told.horizon)]);
  };
  const wake = stamp => {
    viser.takeUp(false);  // a stop may wait there
    const still = window.observerLabFreeze?.on;  // the presenter has paused the class
    const due = player.queue.findIndex(frame => still || frame.due > stamp), many = due < 0 ? player.queue.length : due;
    if (many) player.show(player.queue.splice(0, many));
    player.wake = player.queue.length ? requestAnimationFrame(wake) : 0;
  };
  player.wake ||= requestAnimationFrame(wake);
}
