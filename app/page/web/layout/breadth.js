// Runs before viser's page: its sheet for phones, which it has below 36em, lies in every window that has no room for two columns beside
// the stage. `page.css` and `sizes.py` say the same.
() => {
  const theirs = window.matchMedia;
  window.matchMedia = query => theirs.call(window, query === '(max-width: 36em)' ? '(max-width: 56em)' : query);
}
