// Closes the dialog that is open by Escape, and by a press beside it.
() => {
  if (window.observerLabDialogs) return;
  window.observerLabDialogs = true;
  const close = () => document.querySelector('.ol-close')?.click();
  document.addEventListener('keydown', event => { if (event.key === 'Escape') close(); });
  document.addEventListener('pointerdown', event => { if (event.target?.matches?.(window.observerLabViser.parts.besideDialog)) close(); });
}
