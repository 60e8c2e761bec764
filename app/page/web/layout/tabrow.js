// The figures' tabs stand in one row, which a wheel or a finger slides: the chosen one comes to its middle, and an edge
// beyond which there are more fades.
() => {
  const ROWS = `${window.observerLabViser.parts.column} [role=tablist]`;
  const lab = window.observerLabTabRow ??= {chosen: new WeakMap(), tabs: new WeakSet()};
  const calm = matchMedia('(prefers-reduced-motion: reduce)');
  const fade = row => {
    const over = row.scrollWidth - row.clientWidth;
    row.toggleAttribute('data-before', over > 1 && row.scrollLeft > 1);
    row.toggleAttribute('data-after', over > 1 && row.scrollLeft < over - 1);
  };
  const centre = (row, behavior) => {
    const tab = lab.chosen.get(row)?.getBoundingClientRect(), room = row.getBoundingClientRect();
    if (tab) row.scrollBy({left: (tab.left + tab.right - room.left - room.right) / 2, behavior});
    fade(row);
  };
  lab.look = () => {
    for (const row of document.querySelectorAll(ROWS)) {
      const chosen = row.querySelector('[aria-selected=true]'), first = !lab.chosen.has(row);
      if (first) {
        row.addEventListener('scroll', () => fade(row), {passive: true});
        row.addEventListener('wheel', event => {
          if (row.scrollWidth <= row.clientWidth) return;
          event.preventDefault();
          row.scrollBy({left: event.deltaX || event.deltaY, behavior: 'instant'});
        }, {passive: false});
        lab.sizes.observe(row);
      }
      for (const tab of row.children) if (!lab.tabs.has(tab)) { lab.tabs.add(tab); lab.sizes.observe(tab); }
      if (first || lab.chosen.get(row) !== chosen) {
        lab.chosen.set(row, chosen);
        centre(row, first || calm.matches ? 'instant' : 'smooth');
      }
    }
  };
  if (!lab.sizes) {
    lab.sizes = new ResizeObserver(all => { for (const row of new Set(all.map(({target}) => target.closest('[role=tablist]')))) if (row) centre(row, 'instant'); });
    new MutationObserver(() => lab.look()).observe(document.body, {childList: true, subtree: true, attributeFilter: ['aria-selected']});
  }
  lab.look();
}
