// Covers the page with a sentence while the presenter pauses the class: no hand, no key and no run moves anything under it.
({words}) => {
  const lab = window.observerLabFreeze ??= {}, cover = lab.cover ??= Object.assign(document.createElement('section'), {className: 'ol-freeze'});
  lab.on = !!words;
  cover.setAttribute('role', 'alert');
  cover.hidden = !words;
  if (!cover.isConnected) document.body.append(cover);
  if (cover.textContent !== words) cover.textContent = words;
  [...document.body.children].forEach(each => { if (each !== cover && each.tagName !== 'SCRIPT') each.inert = lab.on; });
  if (lab.listens) return;
  lab.listens = true;
  ['keydown', 'keyup'].forEach(kind => addEventListener(kind, event => { if (lab.on) event.stopImmediatePropagation(); }, true));
}
