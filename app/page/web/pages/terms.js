// Shows what a term means beside it, while the pointer or the focus is on it; a tap shows it too. A term that comes to lie under a pointer
// that has pressed something else and rests there is not asked about.
() => {
  if (window.observerLabTerms) return;
  window.observerLabTerms = true;
  const tip = Object.assign(document.createElement('div'), {id: 'ol-tip', className: 'ol-tip', hidden: true, role: 'tooltip'});
  document.body.append(tip);
  const hide = () => { tip.hidden = true; };
  const show = term => {
    if (term.title) { term.dataset.words = term.title; term.removeAttribute('title'); }
    const words = Object.assign(document.createElement('p'), {textContent: term.dataset.words}), formula = document.createElement('div');
    formula.innerHTML = term.dataset.formula ?? '';
    tip.replaceChildren(words, formula);
    term.setAttribute('aria-describedby', 'ol-tip');
    tip.hidden = false;
    const at = term.getBoundingClientRect(), size = tip.getBoundingClientRect();
    const below = at.bottom + 6, above = at.top - size.height - 6;
    tip.style.left = `${Math.max(8, Math.min(at.left, innerWidth - size.width - 8))}px`;
    tip.style.top = `${below + size.height < innerHeight - 8 || above < 8 ? below : above}px`;
  };
  const term = event => event.target?.closest?.('.ol-term');
  let pressed = null;  // where the pointer has pressed and still rests
  const rests = ({clientX, clientY}) => pressed !== null && Math.hypot(clientX - pressed[0], clientY - pressed[1]) < 2;
  document.addEventListener('pointerdown', event => { pressed = [event.clientX, event.clientY]; }, true);
  document.addEventListener('pointermove', event => {
    if (pressed === null || rests(event)) return;
    pressed = null;
    if (term(event)) show(term(event));
  });
  document.addEventListener('pointerover', event => { if (term(event) && !rests(event)) show(term(event)); });
  for (const kind of ['focusin', 'click']) document.addEventListener(kind, event => { if (term(event)) show(term(event)); });
  for (const kind of ['pointerout', 'focusout']) document.addEventListener(kind, event => { if (term(event)) hide(); });
  document.addEventListener('pointerdown', event => { if (!term(event)) hide(); });
  document.addEventListener('scroll', hide, true);
  document.addEventListener('keydown', event => { if (event.key === 'Escape') hide(); });
}
