// Runs before viser's page: shows the server the ticket of the place that this tab had, when it connects again or is loaded again. While the
// page is seen its ticket stands nowhere else, so that a copy of the tab gets a place of its own.
({kept, field}) => {
  const viser = window.observerLabViser, own = window.observerLabAddress.own(kept), base = viser.server;
  let ticket = '';
  const store = act => { try { return act(sessionStorage) ?? ''; } catch (error) { return ''; } };
  const show = () => { viser.server = ticket ? `${base}${base.includes('?') ? '&' : '?'}${field}=${ticket}` : base; };
  const leave = () => { if (ticket) store(kept => kept.setItem(own, ticket)); };
  const stay = () => store(kept => kept.removeItem(own));
  window.observerLabPlace = {take: given => {
    ticket = given;
    show();
    if (document.hidden) leave();
  }};
  ticket = store(kept => kept.getItem(own));
  show();
  if (!document.hidden) stay();
  document.addEventListener('visibilitychange', () => { (document.hidden ? leave : stay)(); });
  addEventListener('pagehide', leave);
  addEventListener('pageshow', stay);
}
