// All places are taken: a tab that had one shows its ticket.
({kept, field}) => {
  const folder = location.pathname.replace(/[^/]*$/, ''), asked = new URLSearchParams(location.search);
  let ticket = '';
  try { ticket = sessionStorage.getItem(kept + (folder === '/' ? '' : folder)) ?? ''; } catch (error) { console.warn('no storage', error); }
  if (!ticket || asked.has(field)) return;
  asked.set(field, ticket);
  location.replace(`${location.pathname}?${asked}${location.hash}`);
}
