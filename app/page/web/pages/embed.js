// Runs before viser's page: what it plays instead of asking a server.
({recording, dark}) => {
  window.__VISER_EMBED_DATA__ = recording;
  window.__VISER_EMBED_CONFIG__ = {darkMode: dark};
}
