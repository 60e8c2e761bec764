// Asks once more, now from a page of this server: a browser keeps a strict cookie back from links on other sites' pages.
() => {
  const asked = new URLSearchParams(location.search), again = asked.has('again');
  asked.set('again', '');
  if (!again) location.replace(`${location.pathname}?${asked}${location.hash}`);
}
