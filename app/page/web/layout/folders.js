// Lets Tab reach the heads of folders and Enter or Space open them: viser opens folders by the mouse alone.
() => {
  if (window.observerLabFolders) return;
  const viser = window.observerLabViser;
  const dress = () => document.querySelectorAll(viser.parts.folderHead).forEach(head => {
    const open = String(viser.isOpen(head));
    if (head.getAttribute('aria-expanded') === open) return;
    head.tabIndex = 0;
    head.setAttribute('role', 'button');
    head.setAttribute('aria-expanded', open);
  });
  let due = 0;
  window.observerLabFolders = new MutationObserver(() => {
    due ||= setTimeout(() => { due = 0; dress(); }, 200);
  });
  window.observerLabFolders.observe(document.body, {childList: true, subtree: true});
  addEventListener('keydown', event => {
    if ((event.key !== 'Enter' && event.key !== ' ') || !event.target?.matches?.('[role=button][aria-expanded]')) return;
    event.preventDefault();
    event.stopPropagation();
    event.target.click();
  }, {capture: true});
  dress();
}
