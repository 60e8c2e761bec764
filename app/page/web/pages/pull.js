// Lets a slider pull the plant while a hand or an arrow key holds it; let go, it springs back to the middle.
() => {
  if (window.observerLabPull) return;
  const lab = window.observerLabPull = {sent: 0, held: null}, PAUSE = 50;  // ms between two messages
  const slider = element => element?.matches?.('input[data-pull]') ? element : null;
  const tell = (each, released) => {
    const share = Number(each.value) / Number(each.max);
    lab.sent = performance.now();
    window.observerLabViser.tell(each.dataset.to, `${each.dataset.pull}:${share}:${released ? 1 : 0}`);
    each.setAttribute('aria-valuetext', `${(share * Number(each.dataset.most)).toPrecision(2)} ${each.dataset.unit}`);
  };
  const later = each => {
    clearTimeout(lab.timer);
    const wait = Math.max(0, lab.sent + PAUSE - performance.now());
    lab.timer = setTimeout(() => { if (lab.held === each) tell(each, false); }, wait);
  };
  const release = event => {
    const each = lab.held;
    if (!each || (event.type === 'keyup' && !/^(Arrow|Page|Home|End)/.test(event.key))) return;
    clearTimeout(lab.timer);
    lab.held = null;
    const free = () => { tell(each, true); each.value = 0; each.setAttribute('aria-valuetext', `0 ${each.dataset.unit}`); };
    setTimeout(free, Math.max(0, lab.sent + PAUSE - performance.now()));  // the page keeps only the last of two messages within 50 ms
  };
  document.addEventListener('input', event => {
    const each = slider(event.target);
    if (!each) return;
    lab.held = each;
    later(each);
  });
  for (const kind of ['pointerup', 'pointercancel', 'keyup', 'blur']) addEventListener(kind, release, true);
}
