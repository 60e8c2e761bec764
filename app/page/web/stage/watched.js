// Says to a widget whether somebody sees the page and lets things move: 1 once it stands before the eyes, 0 when it is hidden.
({widget}) => {
  const calm = matchMedia('(prefers-reduced-motion: reduce)');
  const tell = () => {
    const seen = document.visibilityState === 'visible' && !calm.matches;
    window.observerLabViser.tell(window.observerLabWatched, Number(seen));
  };
  if (!window.observerLabWatched) document.addEventListener('visibilitychange', tell);
  window.observerLabWatched = widget;
  requestAnimationFrame(() => requestAnimationFrame(tell));
}
