// Says to a widget how wide the column on the right stands, a few times after a page was laid out: a busy browser may lose its width.
({widget}) => {
  const viser = window.observerLabViser;
  let left = 12;
  clearTimeout(window.observerLabColumns);
  const tell = () => {
    const column = document.querySelector(viser.parts.column);
    if (column && !document.hidden) viser.tell(widget, Math.round(column.getBoundingClientRect().width));
    if (left-- > 0) window.observerLabColumns = setTimeout(tell, 250);
  };
  window.observerLabColumns = setTimeout(tell, 120);
}
