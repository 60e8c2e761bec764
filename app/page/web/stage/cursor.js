// Puts the cursor of every chart over time where the clock says that the run stands.
// Writes the values of a diagram's wires and how thick they are at that time, too.
// A rule for the whole page would make the browser look through all its elements at every frame.
() => {
  if (window.observerLabCursor) return;
  const {plots} = window.observerLabViser, stands = new WeakMap(), wires = '.ol-wire';
  const look = () => {
    const share = document.querySelector('.ol-clock')?.dataset.share ?? '0';
    for (const chart of plots) {
      if (stands.get(chart) === share) continue;
      chart.style.setProperty('--ol-t', share);
      stands.set(chart, share);
    }
    for (const wire of document.querySelectorAll(wires)) {
      if (stands.get(wire) === share) continue;
      const {said, widths} = wire.dataset, all = said.split('|'), k = Math.round(Number(share) * (all.length - 1));
      wire.setAttribute('stroke-width', widths.split('|')[k]);
      wire.querySelector('text').firstChild.data = all[k];
      stands.set(wire, share);
    }
  };
  window.observerLabCursor = new MutationObserver(look);
  window.observerLabCursor.observe(document.body, {childList: true, subtree: true});
  look();
}
