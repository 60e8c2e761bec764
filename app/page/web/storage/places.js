// Tells which of the figures' tabs and which step of thought is open, opens the tab that a link names, and copies links and hand-ins.
({widget, tabs, steps, tab}) => {
  const lab = window.observerLabAddress;
  if (!lab) return;
  const fresh = !lab.widget, known = lab.told;  // the place of the tab that the server knew before
  lab.told = tabs.indexOf(tab);
  Object.assign(lab, {widget, tabs, steps, placed: ''});
  const heads = () => [...document.querySelectorAll('[role=tab]')].filter(head => lab.tabs.includes(head.textContent.trim()));
  const named = (parts, names) => names.indexOf(parts.map(part => part.textContent.trim()).find(name => names.includes(name)));
  const look = () => {
    const open = [...document.querySelectorAll('[role=button][aria-expanded=true]')];
    const at = {tab: named(heads().filter(head => head.ariaSelected === 'true'), lab.tabs), step: named(open, lab.steps)};
    const said = JSON.stringify(at);
    if (said !== lab.placed) lab.say(at);
    [lab.placed, lab.told] = [said, at.tab];
  };
  lab.look = look;
  const copy = async button => {
    const field = button.parentElement.querySelector('input.ol-link');
    field.value = button.dataset.text ?? location.origin + location.pathname + '#' + button.dataset.token;
    field.select();
    const done = navigator.clipboard ? await navigator.clipboard.writeText(field.value).then(() => true, () => false)
      : document.execCommand('copy');
    if (done) button.textContent = button.dataset.done;
  };
  if (fresh) for (const kind of ['pointerup', 'keyup']) addEventListener(kind, event => {
    const button = event.target?.closest?.('button.ol-copy');
    if (button && (kind === 'pointerup' || event.key === 'Enter' || event.key === ' ')) copy(button);
    else for (const later of [30, 350]) setTimeout(look, later);  // a folder says after a moment that it is open
  });
  if (tab === null || (lab.told === known && window.observerLabKeep?.figure.at >= 0)) return;  // keep.js keeps what a hand has chosen
  const end = performance.now() + 5000, open = () => {
    const head = heads().find(one => one.textContent.trim() === tab);
    if (head?.ariaSelected === 'true') return;
    if (head) window.observerLabViser.openTab(head);
    if (performance.now() < end) setTimeout(open, 100);
  };
  open();
}
