// Says to a widget how wide the column on the right stands, a few times after a page was laid out: a busy browser may lose its width.
// A double click on the head of that column says less than −1, another number each time.
({widget}) => {
  const viser = window.observerLabViser;
  let left = 12;
  clearTimeout(window.observerLabColumns);
  if (!window.observerLabWide) document.addEventListener('dblclick', event => {
    const head = event.target?.closest?.(`${viser.parts.columnHandle},${viser.parts.column} :is(${viser.parts.tab},${viser.parts.panelHead})`);
    if (head) viser.tell(window.observerLabWide.widget, --window.observerLabWide.said);
  });
  window.observerLabWide = {widget, said: -1};
  const tell = () => {
    const column = document.querySelector(viser.parts.column);
    if (column && !document.hidden) viser.tell(widget, Math.round(column.getBoundingClientRect().width));
    if (left-- > 0) window.observerLabColumns = setTimeout(tell, 250);
  };
  window.observerLabColumns = setTimeout(tell, 120);
}
