// Says to a widget how large the window is and whether its owner likes the dark, at once and whenever that changes.
({widget}) => {
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const tell = () => window.__viserMutable.sendMessage(
    {type: 'GuiUpdateMessage', uuid: window.observerLabWindow, updates: {value: [innerWidth, innerHeight, Number(dark.matches)]}});
  if (!window.observerLabWindow) {
    let due = 0;
    const later = () => { clearTimeout(due); due = setTimeout(tell, 250); };
    addEventListener('resize', later);
    dark.addEventListener('change', later);
  }
  window.observerLabWindow = widget;
  tell();
}
