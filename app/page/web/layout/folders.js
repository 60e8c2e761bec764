// Lets Tab reach the heads of folders and Enter or Space open them: viser opens folders by the mouse alone.
() => {
  if (window.observerLabFolders) return;
  const dress = () => document.querySelectorAll('svg[class*="tabler-icon-chevron"]').forEach(icon => {
    const head = icon.parentElement, box = head?.parentElement;
    if (!head?.matches('.mantine-Paper-root') || !box?.matches('.mantine-Paper-root')) return;
    const open = String(icon.matches('[class*="chevron-up"]'));
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
