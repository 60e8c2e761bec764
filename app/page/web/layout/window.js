// Says to a widget how large the window is and whether its owner likes the dark, at once and whenever that changes. The camera is told
// once more when the stage keeps its shape: what viser tells while it changes may be the shape before.
({widget}) => {
  const viser = window.observerLabViser, dark = matchMedia('(prefers-color-scheme: dark)');
  const tell = () => viser.tell(window.observerLabWindow, [innerWidth, innerHeight, Number(dark.matches)]);
  if (!window.observerLabWindow) {
    let due = 0;
    const later = () => { clearTimeout(due); due = setTimeout(tell, 250); };
    addEventListener('resize', later);
    dark.addEventListener('change', later);
    let shaped = 0;
    new ResizeObserver(() => { clearTimeout(shaped); shaped = setTimeout(viser.tellCamera, 250); }).observe(viser.canvas());
  }
  window.observerLabWindow = widget;
  tell();
}
