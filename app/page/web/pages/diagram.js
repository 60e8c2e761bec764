// Lights a block of a diagram with its equation, and an equation with its block, while the pointer or the focus is on either.
() => {
  if (window.observerLabDiagram) return;
  window.observerLabDiagram = true;
  const light = event => {
    const part = event.target?.closest?.('[data-block]'), figure = part?.closest('.ol-drawn');
    for (const lit of document.querySelectorAll('.ol-lit')) lit.classList.remove('ol-lit');
    if (figure) for (const each of figure.querySelectorAll(`[data-block="${part.dataset.block}"]`)) each.classList.add('ol-lit');
  };
  document.addEventListener('pointerover', light);
  document.addEventListener('focusin', light);
}
