// Runs before viser's page: what it plays instead of asking a server.
({recording, dark}) => {
  window.observerLabViser.play(recording, dark);
}
