// Opens the tab of that title, as Enter on it would, and shows the caption's figure in it.
({title, figure}) => {
  const viser = window.observerLabViser, tabs = Array.from(document.querySelectorAll(viser.parts.tab));
  const tab = tabs.find(each => each.checkVisibility() && each.textContent.trim() === title);
  if (!tab) return;
  if (tab.getAttribute('aria-selected') !== 'true') viser.openTab(tab);
  requestAnimationFrame(() => requestAnimationFrame(() => {
    const said = document.querySelector(`.ol-caption[data-figure="${CSS.escape(figure)}"]`);
    const fill = window.observerLabFill;
    if (fill?.large && said) {
      fill.wanted = said.parentElement;
      fill.fill();
    } else (said?.parentElement?.previousElementSibling ?? said)?.scrollIntoView({block: 'nearest'});
    window.observerLabAddress?.look?.();  // the address bar names the tab that opened by itself
  }));
}
