// Asks once more, now from a page of this server: a browser keeps a strict cookie back from links on other sites' pages.
() => {
  if (!new URLSearchParams(location.search).has('again')) location.replace(location.pathname + '?again' + location.hash);
}
