// Closes the dialog that is open by Escape, and by a press beside it; the menu of more, also once something is chosen in it. A
// button opens the search.
() => {
  if (window.observerLabDialogs) return;
  window.observerLabDialogs = true;
  const close = () => document.querySelector('.ol-close')?.click();
  const fold = () => document.querySelectorAll('.ol-more[open]').forEach(menu => { menu.open = false; });
  document.addEventListener('keydown', event => { if (event.key === 'Escape') { fold(); close(); } });
  document.addEventListener('click', event => { if (event.target?.closest?.('.ol-search')) window.observerLabViser.search(); });
  document.addEventListener('click', event => { if (!event.target?.closest?.('.ol-more summary')) fold(); });
  document.addEventListener('pointerdown', event => { if (event.target?.matches?.(window.observerLabViser.parts.besideDialog)) close(); });
}
