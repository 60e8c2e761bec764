// The server has given this tab a place; by this ticket it finds it again.
({ticket}) => {
  window.observerLabPlace?.take(ticket);
}
