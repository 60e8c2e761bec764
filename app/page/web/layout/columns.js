// Says to a widget how wide the column on the right stands, a few times after a page was laid out: a busy browser may lose its width.
({widget}) => {
  let left = 12;
  clearTimeout(window.observerLabColumns);
  const tell = () => {
    const column = document.querySelector('[data-dock-region=right]');
    if (column && !document.hidden) window.__viserMutable.sendMessage(
      {type: 'GuiUpdateMessage', uuid: widget, updates: {value: Math.round(column.getBoundingClientRect().width)}});
    if (left-- > 0) window.observerLabColumns = setTimeout(tell, 250);
  };
  window.observerLabColumns = setTimeout(tell, 120);
}
