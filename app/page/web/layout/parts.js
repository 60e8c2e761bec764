// On a phone one part of the lesson is shown at a time: a press on a name shows it.
() => {
  const root = document.documentElement;
  if (root.dataset.olPart) return;
  root.dataset.olPart = 'predict';
  document.addEventListener('click', event => {
    const name = event.target?.closest?.('.ol-parts button');
    if (!name) return;
    root.dataset.olPart = name.dataset.part;
    name.closest(window.observerLabViser.parts.view)?.scrollTo(0, 0);
    dispatchEvent(new Event('resize'));  // charts that were hidden take their size
  });
}
