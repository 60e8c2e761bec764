// Says to a widget how large the window is and whether its owner likes the dark, at once and whenever that changes. The camera is told
// once more when the stage keeps its shape: what viser tells while it changes may be the shape before.
({widget}) => {
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const tell = () => window.__viserMutable.sendMessage(
    {type: 'GuiUpdateMessage', uuid: window.observerLabWindow, updates: {value: [innerWidth, innerHeight, Number(dark.matches)]}});
  if (!window.observerLabWindow) {
    let due = 0;
    const later = () => { clearTimeout(due); due = setTimeout(tell, 250); };
    addEventListener('resize', later);
    dark.addEventListener('change', later);
    const page = window.__viserMutable;
    let shaped = 0;
    new ResizeObserver(() => { clearTimeout(shaped); shaped = setTimeout(() => page.sendCamera?.(), 250); }).observe(page.canvas);
  }
  window.observerLabWindow = widget;
  tell();
}
