// Lets a file be dropped on an upload button, or on a folder that has one, as if it had been chosen there. Elsewhere a dropped file does
// nothing: the browser would open it in place of the page.
() => {
  if (window.observerLabDrop) return;
  window.observerLabDrop = true;
  const parts = window.observerLabViser.parts, MARK = 'ol-drop-here';
  const brings = event => [...event.dataTransfer?.types ?? []].includes('Files');
  const folder = event => {
    const beside = event.target.closest?.(parts.button)?.parentElement;
    if (beside?.querySelector(':scope > input[type=file]')) return beside;
    for (let at = event.target.closest?.(parts.folder); at; at = at.parentElement?.closest(parts.folder)) {
      if (at.querySelector('input[type=file]')) return at;
    }
    return null;
  };
  const mark = place => {
    document.querySelectorAll(`.${MARK}`).forEach(other => other.classList.toggle(MARK, other === place));
    place?.classList.add(MARK);
  };
  addEventListener('dragover', event => {
    if (!brings(event)) return;
    event.preventDefault();
    const place = folder(event);
    event.dataTransfer.dropEffect = place ? 'copy' : 'none';
    mark(place);
  });
  addEventListener('dragleave', event => { if (!event.relatedTarget) mark(null); });
  addEventListener('drop', event => {
    if (!brings(event)) return;
    event.preventDefault();
    const place = folder(event);
    mark(null);
    if (!place || !event.dataTransfer.files.length) return;
    const input = place.querySelector('input[type=file]'), only = new DataTransfer();
    only.items.add(event.dataTransfer.files[0]);
    input.files = only.files;
    input.dispatchEvent(new Event('change', {bubbles: true}));
  });
}
