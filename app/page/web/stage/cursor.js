// Puts the cursor of every chart over time where the clock says that the run stands.
// A rule for the whole page would make the browser look through all its elements at every frame.
() => {
  if (window.observerLabCursor) return;
  const {plots} = window.observerLabViser, stands = new WeakMap();
  const look = () => {
    const share = document.querySelector('.ol-clock')?.dataset.share ?? '0';
    for (const chart of plots) {
      if (stands.get(chart) === share) continue;
      chart.style.setProperty('--ol-t', share);
      stands.set(chart, share);
    }
  };
  window.observerLabCursor = new MutationObserver(look);
  window.observerLabCursor.observe(document.body, {childList: true, subtree: true});
  look();
}
