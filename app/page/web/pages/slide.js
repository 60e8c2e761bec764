// Lets a slider of our own HTML act while a hand or an arrow key holds it, by the share of its way from `data-from` to its end. One that
// springs goes back to the middle when it is let go; the others stand at `values`, and those that have none are not shown. One that a hand
// has left stays there until the last of its messages is `heard`.
({values, heard}) => {
  const lab = window.observerLabSlide ??= {sent: 0, held: null, left: null, count: 0, values: {}};
  const PAUSE = 50;  // ms between two messages
  Object.assign(lab.values, values);
  if (!heard || heard === lab.count) lab.left = null;
  if (lab.write) { lab.write(); return; }
  const slider = element => element?.matches?.('input[data-slider]') ? element : null, springs = each => each.dataset.springs !== undefined;
  const say = each => {
    const {unit, most} = each.dataset, out = each.nextElementSibling;
    if (unit !== undefined) each.setAttribute('aria-valuetext', `${(each.value / each.max * most).toPrecision(2)} ${unit}`);
    if (out) out.textContent = each.value.replace('-', '−');
  };
  const tell = ({dataset, max}, value, released) => {
    lab.sent = performance.now();
    lab.count += 1;
    window.observerLabViser.tell(dataset.to, `${dataset.slider}:${(value - dataset.from) / (max - dataset.from)}:${released ? 1 : 0}:${lab.count}`);
  };
  const wait = () => Math.max(0, lab.sent + PAUSE - performance.now());  // the page keeps only the last of two messages within 50 ms
  const later = each => {
    clearTimeout(lab.timer);
    lab.timer = setTimeout(() => { if (lab.held === each) tell(each, each.value, false); }, wait());
  };
  const release = event => {
    const each = lab.held, value = each?.value;
    if (!each || (event.type === 'keyup' && !/^(Arrow|Page|Home|End)/.test(event.key))) return;
    clearTimeout(lab.timer);
    lab.held = null;
    lab.left = each;
    setTimeout(() => {
      tell(each, value, true);
      if (springs(each)) { each.value = 0; say(each); }
    }, wait());
  };
  lab.write = () => {
    lab.waits = false;
    for (const each of document.querySelectorAll('input[data-slider]:not([data-springs])')) {
      const value = lab.values[each.dataset.slider], row = each.closest('.ol-pole');
      if (row.hidden !== (value == null)) row.hidden = value == null;
      if (value == null || each === lab.held || each === lab.left) continue;
      each.value = value;
      say(each);
    }
  };
  document.addEventListener('input', event => {
    const each = slider(event.target);
    if (!each) return;
    lab.held = each;
    say(each);
    later(each);
  });
  for (const kind of ['pointerup', 'pointercancel', 'keyup', 'blur']) addEventListener(kind, release, true);
  new MutationObserver(() => { if (!lab.waits) { lab.waits = true; setTimeout(lab.write, 50); } })
    .observe(document.body, {childList: true, subtree: true});
  lab.write();
}
